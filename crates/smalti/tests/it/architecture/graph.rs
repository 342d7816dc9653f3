//! Which file imports from which, names resolved to the file that declares them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::sources::{ModulePath, Modules, Names};

/// Where a path leads.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Target {
    /// An item, by the module that declares it.
    Item(ModulePath),
    Module(ModulePath),
    /// Another crate, by the whole path.
    External(Names),
}

/// The files that each file imports from, and the path by which it does.
pub(super) type Imports = BTreeMap<PathBuf, BTreeMap<PathBuf, String>>;

impl Modules {
    /// What `names`, written in the module `from`, leads to. `None`: a local name, or one that a macro makes.
    pub(super) fn resolve(&self, from: &ModulePath, names: &[String]) -> Option<Target> {
        self.resolve_within(from, names, &mut BTreeSet::new())
    }

    fn resolve_within(
        &self,
        from: &ModulePath,
        names: &[String],
        seen: &mut BTreeSet<(ModulePath, String)>,
    ) -> Option<Target> {
        let mut at = from.clone();
        let mut rest = names;
        // `$crate` in a macro arrives here as `crate`.
        if let Some(after) = rest.strip_prefix(&["crate".to_owned()]) {
            (at, rest) = (Vec::new(), after);
        } else {
            rest = rest.strip_prefix(&["self".to_owned()]).unwrap_or(rest);
            while let Some(after) = rest.strip_prefix(&["super".to_owned()]) {
                at.pop()?;
                rest = after;
            }
        }
        let anchored = rest.len() < names.len();
        let Some(first) = rest.first() else { return anchored.then_some(Target::Module(at)) };
        match self.name_in(&at, first, seen) {
            Some(Target::Module(module)) if rest.len() > 1 => {
                let mut within: Names = vec!["self".into()];
                within.extend_from_slice(&rest[1..]);
                self.resolve_within(&module, &within, seen)
            }
            Some(Target::External(mut path)) => {
                path.extend_from_slice(&rest[1..]);
                Some(Target::External(path))
            }
            None if !anchored && rest.len() > 1 => Some(Target::External(rest.to_vec())),
            found => found,
        }
    }

    /// What `name` means in `module`: a module, an item, an import, or what a glob brings.
    fn name_in(
        &self,
        module: &ModulePath,
        name: &str,
        seen: &mut BTreeSet<(ModulePath, String)>,
    ) -> Option<Target> {
        let mut child = module.clone();
        child.push(name.to_owned());
        if self.by_path.contains_key(&child) {
            return Some(Target::Module(child));
        }
        let here = self.by_path.get(module)?;
        if here.items.iter().any(|i| i == name) {
            return Some(Target::Item(module.clone()));
        }
        if !seen.insert((module.clone(), name.to_owned())) {
            return None;
        }
        let mut found = None;
        if let Some(import) = here.imports.iter().find(|i| i.name == name) {
            found = match self.resolve_within(module, &import.path, seen) {
                None => Some(Target::External(import.path.clone())),
                some => some,
            };
        }
        for glob in here.imports.iter().filter(|i| i.name == "*") {
            if found.is_some() {
                break;
            }
            if let Some(Target::Module(of)) = self.resolve_within(module, &glob.path, seen) {
                found = self.name_in(&of, name, seen);
            }
        }
        seen.remove(&(module.clone(), name.to_owned()));
        found
    }

    /// Every path that counts as an import, with the module it is written in: all code, and `use` items that bind a
    /// name for this module. A `pub use` hands a name on; whoever uses that name imports from the file behind it.
    fn counted(&self) -> impl Iterator<Item = (&ModulePath, &Names)> {
        self.by_path.iter().flat_map(|(path, module)| {
            let imports = module.imports.iter().filter(|i| !i.public).map(|i| &i.path);
            imports.chain(&module.mentions).map(move |names| (path, names))
        })
    }

    /// The imports between the files of the crate.
    pub(super) fn imports(&self) -> Imports {
        let mut imports: Imports = self.by_path.values().map(|m| (m.file.clone(), BTreeMap::new())).collect();
        for (path, names) in self.counted() {
            let Some(Target::Item(declared)) = self.resolve(path, names) else { continue };
            let (from, to) = (&self.by_path[path].file, &self.by_path[&declared].file);
            if from != to {
                imports.entry(from.clone()).or_default().entry(to.clone()).or_insert(names.join("::"));
            }
        }
        imports
    }

    /// Every path of the code, resolved, with the file it is written in: those of `pub use` too.
    pub(super) fn targets(&self) -> impl Iterator<Item = (&Path, &Names, Target)> {
        self.by_path.iter().flat_map(move |(path, module)| {
            let all = module.imports.iter().map(|i| &i.path).chain(&module.mentions);
            all.filter_map(move |names| Some((module.file.as_path(), names, self.resolve(path, names)?)))
        })
    }
}

/// The files that import from each other, directly or through others: each circle as the set of its files.
pub(super) fn circles(imports: &Imports) -> Vec<BTreeSet<PathBuf>> {
    let reached: BTreeMap<&PathBuf, BTreeSet<&PathBuf>> =
        imports.keys().map(|f| (f, reach(imports, f))).collect();
    let mut circles: Vec<BTreeSet<PathBuf>> = Vec::new();
    for (file, others) in &reached {
        if others.contains(file) && !circles.iter().any(|c| c.contains(*file)) {
            let together = others.iter().filter(|o| reached[*o].contains(file));
            circles.push(together.map(|o| (*o).clone()).collect());
        }
    }
    circles
}

fn reach<'a>(imports: &'a Imports, from: &'a PathBuf) -> BTreeSet<&'a PathBuf> {
    let mut reached = BTreeSet::new();
    let mut open = vec![from];
    while let Some(file) = open.pop() {
        open.extend(imports.get(file).into_iter().flat_map(BTreeMap::keys).filter(|f| reached.insert(*f)));
    }
    reached
}

/// A circle as text: each import between its files.
pub(super) fn describe(imports: &Imports, circle: &BTreeSet<PathBuf>) -> String {
    let mut lines = Vec::new();
    for from in circle {
        for (to, name) in imports[from].iter().filter(|(to, _)| circle.contains(*to)) {
            lines.push(format!("  {} imports {name} of {}", from.display(), to.display()));
        }
    }
    lines.join("\n")
}
