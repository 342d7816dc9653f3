//! Every file format Smalti reads and writes, one module each. The only crate of the workspace that opens files.
