//! Modules depend one way only: each uses those before it in the order of `src/lib.rs`.

use std::fs;
use std::path::{Path, PathBuf};

/// The modules that `lib.rs` declares, in order.
fn modules(lib: &str) -> Vec<String> {
    lib.lines()
        .filter_map(|line| line.strip_prefix("pub ").unwrap_or(line).strip_prefix("mod "))
        .map(|name| name.trim_end_matches(';').to_owned())
        .collect()
}

/// Every source file below `folder`, in order.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Code without its comments, which may speak of anything.
fn without_comments(text: &str) -> String {
    text.lines().map(|line| line.split("//").next().unwrap_or(line)).collect::<Vec<_>>().join("\n")
}

/// The first name of every path that begins at the root of the crate.
fn uses(code: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        let path = &code[at + "crate::".len()..];
        match path.strip_prefix('{') {
            None => found.push(first_name(path)),
            Some(group) => {
                let mut depth = 0;
                let mut start = 0;
                for (i, c) in group.char_indices() {
                    match c {
                        '{' => depth += 1,
                        ',' | '}' if depth == 0 => {
                            found.push(first_name(group[start..i].trim_start()));
                            start = i + 1;
                            if c == '}' {
                                break;
                            }
                        }
                        '}' => depth -= 1,
                        _ => {}
                    }
                }
            }
        }
    }
    found.retain(|name| !name.is_empty());
    found
}

fn first_name(path: &str) -> String {
    path.chars().take_while(|&c| c.is_alphanumeric() || c == '_').collect()
}

/// How many `super::` the longest chain of them has.
fn steps_up(code: &str) -> usize {
    (1..).take_while(|&n| code.contains(&"super::".repeat(n))).count()
}

#[test]
fn each_module_uses_only_those_before_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let order = modules(&fs::read_to_string(root.join("lib.rs")).expect("src/lib.rs"));
    assert!(order.len() > 15, "{order:?}");
    let place = |name: &str| order.iter().position(|m| m == name);
    let mut wrong = Vec::new();
    let mut seen = vec![false; order.len()];
    let mut paths = 0;
    for file in sources(&root) {
        let within = file.strip_prefix(&root).expect("below src").with_extension("");
        let mut names: Vec<String> = within.iter().map(|n| n.to_string_lossy().into_owned()).collect();
        if names == ["lib"] || names == ["main"] {
            continue;
        }
        if names.last().is_some_and(|n| n == "mod") {
            names.pop();
        }
        let own = place(&names[0]).unwrap_or_else(|| panic!("{} is not declared in lib.rs", names[0]));
        seen[own] = true;
        let code = without_comments(&fs::read_to_string(&file).expect("a source file"));
        for name in uses(&code) {
            paths += 1;
            match place(&name) {
                Some(used) if used <= own => {}
                Some(_) => wrong.push(format!("{} uses {name}, which comes later", within.display())),
                None => wrong.push(format!("{} names crate::{name}, which is no module", within.display())),
            }
        }
        // `super` must not lead out of the module by the back door; a module of tests is one deeper.
        for (part, depth) in code.split("#[cfg(test)]\nmod tests").zip(names.len()..) {
            if steps_up(part) >= depth {
                wrong.push(format!("{} leads out of {} by super", within.display(), names[0]));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(seen.iter().all(|&s| s), "{order:?} {seen:?}");
    assert!(paths > 100, "only {paths} paths were found: does this test still read them?");
}

#[test]
fn paths_are_found_in_every_shape() {
    let code = "use crate::a::{B, c::D};\nuse crate::{e, f::{G, h}, i};\nlet x = crate::j::K;";
    assert_eq!(uses(code), ["a", "e", "f", "i", "j"]);
    assert_eq!(uses(&without_comments("// crate::a\n/// [b](crate::b)\nx")), [""; 0]);
    assert_eq!(steps_up("use super::super::x; use super::y;"), 2);
    assert_eq!(modules("pub mod a;\n// b\nmod b;\n#[cfg(x)]\npub mod c;\npub use d;"), ["a", "b", "c"]);
}
