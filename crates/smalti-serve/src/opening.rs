//! How a browser is sent to a page without its address in a command line, which other accounts of the machine can read.

use std::path::{Path, PathBuf};
use std::{env, fs, io};

use smalti_io::write;

use crate::ServeError;
use crate::address::random_token;

/// The name of the file.
const FILE: &str = "open.html";

/// A file that leads a browser to a page with a token. It lies in a temporary folder of its own; where the system has such permissions, only the user who runs
/// the program can read both. Both are removed when this is dropped.
#[derive(Debug)]
pub struct OpeningFile {
    folder: PathBuf,
}

impl OpeningFile {
    /// Writes the file for an address.
    ///
    /// # Errors
    /// When the folder or the file cannot be made.
    pub fn new(address: &str) -> Result<Self, ServeError> {
        let folder = env::temp_dir().join(format!("smalti-{}", random_token()?));
        private_folder(&folder).map_err(ServeError::Opening)?;
        // From here on, an error removes the folder.
        let file = Self { folder };
        write::secret(&file.path(), page(address).as_bytes())?;
        Ok(file)
    }

    /// The path of the file.
    #[must_use]
    pub fn path(&self) -> PathBuf {
        self.folder.join(FILE)
    }
}

impl Drop for OpeningFile {
    fn drop(&mut self) {
        // A temporary folder that cannot be removed is left to the system.
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// Makes a folder that was not there.
fn private_folder(path: &Path) -> io::Result<()> {
    let mut builder = fs::DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(path)
}

/// A page that leads to an address of this server, which has no characters with a meaning in HTML.
fn page(address: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<meta name=\"referrer\" content=\"no-referrer\">\n\
         <meta http-equiv=\"refresh\" content=\"0; url={address}\">\n<title>Smalti</title>\n<p><a href=\"{address}\">Open the page</a></p>\n</html>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LocalServer;

    #[test]
    fn only_the_user_can_read_the_file_and_it_leads_to_the_page() {
        let address = LocalServer::bind(None, None).unwrap().url();
        let file = OpeningFile::new(&address).unwrap();
        let path = file.path();
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(&format!("content=\"0; url={address}\"")), "{text}");
        assert!(text.contains(&format!("<a href=\"{address}\">")), "{text}");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
            assert_eq!((mode(&path), mode(path.parent().unwrap())), (0o600, 0o700));
        }
        // Neither the token nor anything else of the address is in the path.
        let token = address.trim_end_matches('/').rsplit('/').next().unwrap();
        assert!(!path.to_str().unwrap().contains(token));
        let folder = path.parent().unwrap().to_owned();
        drop(file);
        assert!(!folder.exists());
    }
}
