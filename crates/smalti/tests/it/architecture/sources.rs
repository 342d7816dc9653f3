//! A crate's modules, parsed: which file declares which name, and which paths its code mentions.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use syn::buffer::{Cursor, TokenBuffer};
use syn::visit::{self, Visit};

/// A module's path from the root of its crate; the root is empty.
pub(super) type ModulePath = Vec<String>;
/// The names of a path as written, `crate`, `self` and `super` included.
pub(super) type Names = Vec<String>;

/// The modules of one target of a crate.
#[derive(Debug, Default)]
pub(super) struct Modules {
    pub(super) by_path: BTreeMap<ModulePath, Module>,
}

#[derive(Debug, Default)]
pub(super) struct Module {
    /// The source file, relative to `src`. A module written inline shares the file of its parent.
    pub(super) file: PathBuf,
    /// Items declared here: types, functions, constants, macros.
    pub(super) items: Vec<String>,
    pub(super) imports: Vec<Import>,
    /// Paths mentioned in code outside `use` items, and macros called, as their names with a last `!`.
    pub(super) mentions: Vec<Names>,
}

/// One leaf of a `use` item.
#[derive(Debug, Clone)]
pub(super) struct Import {
    pub(super) path: Names,
    /// The name that the import binds; `*` for a glob.
    pub(super) name: String,
    /// A `pub use` gives a name to others and is not itself a use of it.
    pub(super) public: bool,
}

impl Modules {
    /// Reads the target whose root is `root`, following its `mod` declarations. Code compiled for tests alone is
    /// left out.
    pub(super) fn read(src: &Path, root: &str) -> Self {
        let mut modules = Self::default();
        modules.read_file(src, Path::new(root), &Vec::new());
        modules
    }

    /// One file on its own, for tests of this reader. Modules that it declares become empty files.
    pub(super) fn add_text(&mut self, file: &str, text: &str) {
        let path = module_path(Path::new(file));
        let parsed = syn::parse_file(text).unwrap_or_else(|e| panic!("{file}: {e}"));
        self.add_items(None, Path::new(file), &path, &parsed.items);
    }

    fn read_file(&mut self, src: &Path, file: &Path, path: &ModulePath) {
        let text = std::fs::read_to_string(src.join(file)).unwrap();
        let parsed = syn::parse_file(&text).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        self.add_items(Some(src), file, path, &parsed.items);
    }

    fn add_items(&mut self, src: Option<&Path>, file: &Path, path: &ModulePath, items: &[syn::Item]) {
        let mut module = Module { file: file.to_path_buf(), ..Module::default() };
        for item in items {
            match item {
                syn::Item::Mod(m) if !only_for_tests(&m.attrs) => {
                    let name = m.ident.to_string();
                    let mut child = path.clone();
                    child.push(name.clone());
                    match (&m.content, src) {
                        (Some((_, items)), _) => self.add_items(src, file, &child, items),
                        (None, Some(src)) => self.read_file(src, &child_file(src, file, &child), &child),
                        (None, None) => {}
                    }
                }
                _ => module.visit_item(item),
            }
        }
        self.by_path.insert(path.clone(), module);
    }
}

/// `sensor/cfa/mod.rs` and `sensor/cfa.rs` are the module `sensor::cfa`; `lib.rs` is the root.
pub(super) fn module_path(file: &Path) -> ModulePath {
    let names = file.with_extension("");
    let all = names.iter().map(|n| n.to_string_lossy().into_owned());
    all.filter(|n| !matches!(n.as_str(), "mod" | "lib" | "main")).collect()
}

/// The file of the module `child` that `file` declares, relative to `src`.
fn child_file(src: &Path, file: &Path, child: &ModulePath) -> PathBuf {
    let stem: PathBuf = child.iter().collect();
    let candidates = [stem.with_extension("rs"), stem.join("mod.rs")];
    let found = candidates.into_iter().find(|f| src.join(f).is_file());
    found.unwrap_or_else(|| panic!("{}: no file for the module {}", file.display(), child.join("::")))
}

fn only_for_tests(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|a| {
        let syn::Meta::List(list) = &a.meta else { return false };
        let condition = list.tokens.to_string();
        list.path.is_ident("cfg") && (condition == "test" || condition.starts_with("all (test"))
    })
}

fn attributes(item: &syn::Item) -> &[syn::Attribute] {
    use syn::Item;
    match item {
        Item::Const(i) => &i.attrs,
        Item::Enum(i) => &i.attrs,
        Item::Fn(i) => &i.attrs,
        Item::Impl(i) => &i.attrs,
        Item::Macro(i) => &i.attrs,
        Item::Mod(i) => &i.attrs,
        Item::Static(i) => &i.attrs,
        Item::Struct(i) => &i.attrs,
        Item::Trait(i) => &i.attrs,
        Item::Type(i) => &i.attrs,
        Item::Use(i) => &i.attrs,
        _ => &[],
    }
}

fn declared_name(item: &syn::Item) -> Option<String> {
    use syn::Item;
    let ident = match item {
        Item::Const(i) => &i.ident,
        Item::Enum(i) => &i.ident,
        Item::Fn(i) => &i.sig.ident,
        Item::Macro(i) => i.ident.as_ref()?,
        Item::Static(i) => &i.ident,
        Item::Struct(i) => &i.ident,
        Item::Trait(i) => &i.ident,
        Item::Type(i) => &i.ident,
        Item::Union(i) => &i.ident,
        _ => return None,
    };
    Some(ident.to_string())
}

impl<'ast> Visit<'ast> for Module {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        if only_for_tests(attributes(item)) {
            return;
        }
        self.items.extend(declared_name(item));
        visit::visit_item(self, item);
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        let public = !matches!(item.vis, syn::Visibility::Inherited);
        self.add_use(&item.tree, &mut Vec::new(), public);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        self.mentions.push(path.segments.iter().map(|s| s.ident.to_string()).collect());
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, called: &'ast syn::Macro) {
        let mut names: Names = called.path.segments.iter().map(|s| s.ident.to_string()).collect();
        names.push("!".into());
        self.mentions.push(names);
        // What a macro is given need not be Rust; its paths are found in the tokens.
        self.add_tokens(TokenBuffer::new2(called.tokens.clone()).begin());
    }

    // `pub(in crate::sensor)` says who may see an item and imports nothing.
    fn visit_vis_restricted(&mut self, _: &'ast syn::VisRestricted) {}

    fn visit_attribute(&mut self, _: &'ast syn::Attribute) {}
}

impl Module {
    fn add_use(&mut self, tree: &syn::UseTree, prefix: &mut Names, public: bool) {
        let depth = prefix.len();
        let leaf = |prefix: &Names, last: Option<String>, name: String| {
            // `use a::{self}` imports a.
            let path = prefix.iter().cloned().chain(last.filter(|l| l != "self" || prefix.is_empty()));
            let name = if name == "self" { prefix.last().cloned().unwrap_or(name) } else { name };
            Import { path: path.collect(), name, public }
        };
        match tree {
            syn::UseTree::Path(p) => {
                prefix.push(p.ident.to_string());
                self.add_use(&p.tree, prefix, public);
                prefix.truncate(depth);
            }
            syn::UseTree::Group(g) => g.items.iter().for_each(|t| self.add_use(t, prefix, public)),
            syn::UseTree::Name(n) => {
                self.imports.push(leaf(prefix, Some(n.ident.to_string()), n.ident.to_string()));
            }
            syn::UseTree::Rename(r) => {
                self.imports.push(leaf(prefix, Some(r.ident.to_string()), r.rename.to_string()));
            }
            syn::UseTree::Glob(_) => self.imports.push(leaf(prefix, None, "*".into())),
        }
    }

    fn add_tokens(&mut self, mut cursor: Cursor<'_>) {
        while !cursor.eof() {
            if let Some((inside, _, _, next)) = cursor.any_group() {
                self.add_tokens(inside);
                cursor = next;
                continue;
            }
            let Some((ident, mut next)) = cursor.ident() else {
                // A field or a method after a dot is no path.
                let dot = cursor.punct().is_some_and(|(p, _)| p.as_char() == '.');
                let Some((_, next)) = cursor.token_tree() else { return };
                cursor = if dot { next.ident().map_or(next, |(_, after)| after) } else { next };
                continue;
            };
            let mut names = vec![ident.to_string()];
            while let Some((ident, after)) = colon(next).and_then(colon).and_then(Cursor::ident) {
                names.push(ident.to_string());
                next = after;
            }
            if let Some((_, after)) = next.punct().filter(|(p, _)| p.as_char() == '!')
                && after.any_group().is_some()
            {
                names.push("!".into());
            }
            self.mentions.push(names);
            cursor = next;
        }
    }
}

/// Past a colon.
fn colon(cursor: Cursor<'_>) -> Option<Cursor<'_>> {
    cursor.punct().filter(|(p, _)| p.as_char() == ':').map(|(_, next)| next)
}
