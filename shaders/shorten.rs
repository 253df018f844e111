//! Shaders in fewer words that do the same: with shorter names, and GLSL of naga's with numbers for constants and with
//! values where they are used. Shared by the build script and by `tests/suite/shaders.rs`.

use std::collections::{BTreeMap, BTreeSet};

/// WGSL or GLSL without comments and most spaces: it travels inside the WebAssembly module.
pub fn minify(source: &str) -> String {
    // Beside these no space is needed; without the minus, since two of them are something else.
    let parts = |c: char| "(),;:{}=+*/<>&|?!^[]".contains(c);
    let mut short = String::new();
    for line in source.lines() {
        let code = line.split("//").next().unwrap_or_default().trim();
        if code.starts_with('#') {
            short.push_str(code);
            short.push('\n');
            continue;
        }
        let mut rest = code.chars().peekable();
        while let Some(c) = rest.next() {
            let next = rest.peek().copied();
            let is_needless =
                short.ends_with(|c: char| parts(c) || c.is_whitespace()) || next.is_some_and(parts);
            if c != ' ' || !is_needless {
                short.push(c);
            }
        }
        if !short.ends_with(parts) {
            short.push('\n');
        }
    }
    short
}

/// WGSL with one or two letters for each name that it declares, but for those to keep: names are a third of a
/// shader. A name is the same everywhere, so what shadowed another still does.
pub fn shorten(wgsl: &str, keep: &[&str]) -> String {
    const DECLARING: [&str; 5] = ["fn", "let", "var", "const", "struct"];
    let tokens = tokens(wgsl);
    let is_name = |token: &str| token.starts_with(|c: char| c.is_alphabetic() || c == '_');
    // The token before or after, spaces left out.
    let before = |i: usize| tokens[..i].iter().rev().find(|t| !t.trim().is_empty());
    let after = |i: usize| tokens[i + 1..].iter().find(|t| !t.trim().is_empty());
    let (mut counts, mut callable) = (BTreeMap::new(), BTreeSet::new());
    for (i, &token) in tokens.iter().enumerate() {
        let declaring = before(i).filter(|word| DECLARING.contains(word));
        if is_name(token) && (declaring.is_some() || after(i) == Some(&":")) {
            counts.insert(token, 0);
            if declaring.is_some_and(|word| ["fn", "struct"].contains(word)) {
                callable.insert(token);
            }
        }
    }
    // An attribute or its argument, or a component of a vector.
    let is_fixed = |i: usize| {
        let component = |c: char| "xyzwrgba".contains(c);
        let is_attribute = (i >= 1 && tokens[i - 1] == "@")
            || (i >= 3 && tokens[i - 1] == "(" && tokens[i - 3] == "@");
        is_attribute || (before(i) == Some(&".") && tokens[i].chars().all(component))
    };
    for (i, token) in tokens.iter().enumerate() {
        if after(i) == Some(&"(") && !callable.contains(token) {
            // Something built in has the name too.
            counts.remove(token);
        } else if !is_fixed(i) {
            counts.entry(token).and_modify(|count| *count += 1);
        }
    }
    for name in keep {
        counts.remove(name);
    }
    let short = short_names(counts, &tokens);
    let renamed = |(i, token): (usize, &&'_ str)| match short.get(token) {
        Some(name) if !is_fixed(i) => name.clone(),
        _ => token.to_string(),
    };
    let short: String = tokens.iter().enumerate().map(renamed).collect();
    rename_locals(&short, |tokens| {
        let named = tokens.windows(3).filter_map(|near| match near {
            ["let" | "var", " ", name] => Some(*name),
            [_, name, ":"] if is_name(name) => Some(*name),
            _ => None,
        });
        named.collect()
    })
}

/// GLSL of which each declaration is changed as often as there is something to change in it.
fn settled(glsl: &str, change_one: impl Fn(&str) -> Option<String>) -> String {
    let settle = |declaration: &str| {
        let mut text = declaration.to_owned();
        while let Some(changed) = change_one(&text) {
            text = changed;
        }
        text
    };
    declarations(glsl).map(settle).collect()
}

/// A function in which a variable, the first that there is, is declared where it is first set, and not before with a value
/// that nobody reads. Naga declares each at the start of a block that may be far around.
fn declare_late(function: &str) -> Option<String> {
    let tokens = tokens(function);
    let is_edge = |token: &str| [";", "{", "}"].contains(&token);
    let end_from = |start: usize| (start..tokens.len()).find(|&i| tokens[i] == ";");
    (1..tokens.len()).filter(|&start| is_edge(tokens[start - 1])).find_map(|start| {
        let end = end_from(start)?;
        let [kind, " ", name, "=", ..] = &tokens[start..end] else { return None };
        // Not a field that is called so.
        let uses: Vec<usize> =
            (end..tokens.len()).filter(|&i| tokens[i] == *name && tokens[i - 1] != ".").collect();
        let (&set, after) = uses.split_first()?;
        let is_set = is_edge(tokens[set - 1]) && tokens[set + 1] == "=" && tokens[set + 2] != "=";
        let set_end = end_from(set)?;
        // The block in which it is set must be all that has use for it.
        let mut depth = 1;
        let is_end = |&token: &&str| {
            depth += i32::from(token == "{") - i32::from(token == "}");
            depth == 0
        };
        let block_end = set + tokens[set..].iter().position(is_end)?;
        let is_own = after.iter().all(|&i| i > set_end && i < block_end);
        if !is_set || !is_own {
            return None;
        }
        let (before, between) = (tokens[..start].concat(), tokens[end + 1..set].concat());
        Some([&before, &between, *kind, " ", &tokens[set..].concat()].concat())
    })
}

/// A function in which a value, the first that there is, is worked out in the next statement, which alone has use for it.
/// Naga gives each a name and a statement of its own. Nothing comes between the two, and nothing in either changes what
/// the other reads.
fn join_value(function: &str) -> Option<String> {
    let tokens = tokens(function);
    let statements: Vec<usize> =
        (0..tokens.len()).filter(|&i| [";", "{", "}"].contains(&tokens[i])).collect();
    statements.windows(3).find_map(|ends| {
        let &[start, end, stop] = ends else { return None };
        let [_, " ", name, "=", value @ ..] = &tokens[start + 1..end] else { return None };
        // Not a field that is called so.
        let mut uses = (end..tokens.len()).filter(|&i| tokens[i] == *name && tokens[i - 1] != ".");
        let place = uses.next()?;
        // What the next statement begins with is set there.
        if tokens[end] != ";" || place == end + 1 || place > stop || uses.next().is_some() {
            return None;
        }
        let is_whole =
            value.first()?.starts_with(|c: char| c.is_alphanumeric() || "_(".contains(c));
        let [open, close] = if is_whole { ["", ""] } else { ["(", ")"] };
        let (before, after) = (&tokens[end + 1..place], &tokens[place + 1..]);
        let value = [open, &value.concat(), close].concat();
        Some([tokens[..=start].concat(), before.concat(), value, after.concat()].concat())
    })
}

/// GLSL with a letter for each of the values and names that naga has numbered, and with numbers in the places of
/// constants. What is worked out for the next statement alone is part of it.
pub fn shorten_values(glsl: &str) -> String {
    let glsl = settled(&settled(&without_constants(glsl), declare_late), join_value);
    rename_locals(&glsl, |tokens| {
        // A type, and what is called so: a variable or a parameter.
        let is_name = |token: &str| token.starts_with(|c: char| c.is_alphabetic() || c == '_');
        let named = tokens.windows(4).filter_map(|near| match near {
            [kind, " ", name, "=" | "," | ";" | ")"] if is_name(kind) && *kind != "return" => {
                Some(*name)
            }
            _ => None,
        });
        named.collect()
    })
}

/// A shader in which the variables and parameters of each function, which are told of its tokens, are named in the order
/// in which it has them. What functions have in common packs better so, and one that is in several shaders is the same
/// text in all, which packs to nothing.
fn rename_locals(shader: &str, locals: impl for<'a> Fn(&[&'a str]) -> Vec<&'a str>) -> String {
    let mut short = String::new();
    for declaration in declarations(shader) {
        let tokens = tokens(declaration);
        let mut names = locals(&tokens);
        if !is_function(declaration) {
            names.clear();
        }
        // Neither a field that is called so nor a function.
        let is_local = |i: usize| {
            names.contains(&tokens[i])
                && (i == 0 || tokens[i - 1] != ".")
                && tokens.get(i + 1) != Some(&"(")
        };
        let others =
            (0..tokens.len()).filter(|&i| !is_local(i)).map(|i| tokens[i]).collect::<Vec<&str>>();
        let mut free = free_names(&others);
        let mut renamed = BTreeMap::new();
        for &name in &names {
            renamed.entry(name).or_insert_with(|| free.next().unwrap_or_default());
        }
        for (i, &token) in tokens.iter().enumerate() {
            short.push_str(if is_local(i) { &renamed[token] } else { token });
        }
    }
    short
}

/// GLSL with numbers in the places of its constants.
fn without_constants(glsl: &str) -> String {
    let mut numbers = BTreeMap::new();
    let mut rest = String::new();
    for declaration in declarations(glsl) {
        let constant =
            declaration.strip_prefix("const uint ").and_then(|own| own.strip_suffix(';'));
        match constant.and_then(|own| own.split_once('=')) {
            Some((name, number)) => drop(numbers.insert(name, number)),
            None => rest.push_str(declaration),
        }
    }
    let mut before = "";
    let number = |token| {
        // Not a field that is called so.
        let number = numbers.get(token).filter(|_| before != ".");
        before = token;
        number.copied().unwrap_or(token)
    };
    tokens(&rest).into_iter().map(number).collect()
}

/// The declarations of a shader, one after the other, with all between them.
pub fn declarations(glsl: &str) -> impl Iterator<Item = &str> {
    let mut depth = 0;
    glsl.split_inclusive(move |c: char| {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        depth == 0 && matches!(c, ';' | '}')
    })
}

/// Whether it is a function that is declared, in WGSL or in GLSL. A block of uniforms has parentheses and braces too.
fn is_function(declaration: &str) -> bool {
    let head = declaration.split('{').next().unwrap_or_default();
    head.len() < declaration.len() && (head.ends_with(')') || head.contains(")->"))
}

/// The shortest names that are free, for those that are used most.
fn short_names<'a>(
    counts: BTreeMap<&'a str, u32>,
    tokens: &[&'a str],
) -> BTreeMap<&'a str, String> {
    let mut often: Vec<(&str, u32)> = counts.into_iter().collect();
    often.sort_by_key(|&(name, count)| (std::cmp::Reverse(count), name));
    often.into_iter().map(|(name, _)| name).zip(free_names(tokens)).collect()
}

/// Names that none of the tokens has, the shortest first.
fn free_names(tokens: &[&str]) -> impl Iterator<Item = String> {
    let taken: BTreeSet<String> = tokens.iter().map(|token| token.to_string()).collect();
    let letters = || ('a'..='z').chain('A'..='Z');
    let pairs = letters().flat_map(move |a| letters().map(move |b| format!("{a}{b}")));
    let reserved = ["as", "do", "if", "in", "is", "of", "or", "fn"];
    letters()
        .map(String::from)
        .chain(pairs)
        .filter(move |name| !taken.contains(name) && !reserved.contains(&&name[..]))
}

/// Names, numbers, and the single characters between them.
pub fn tokens(text: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let len = match first {
            c if c.is_numeric() => rest.find(|c: char| !is_word(c) && c != '.'),
            c if is_word(c) => rest.find(|c: char| !is_word(c)),
            c => Some(c.len_utf8()),
        };
        let (token, left) = rest.split_at(len.unwrap_or(rest.len()));
        tokens.push(token);
        rest = left;
    }
    tokens
}
