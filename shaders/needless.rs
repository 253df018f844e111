//! GLSL without what changes nothing: parentheses, which naga puts around all that it works out, braces around one statement,
//! and zeros at the ends of numbers. They are a twentieth of what a page fetches.

use super::shorten::{declarations, tokens};

/// How tightly an operator binds what is beside it: the table of GLSL ES 3.00, section 5.1, the tightest last. All of two
/// sides group from the left but the first two here.
const OPERATORS: [&[&str]; 12] = [
    &["="],
    &["?", ":"],
    &["||"],
    &["^^"],
    &["&&"],
    &["|"],
    &["^"],
    &["&"],
    &["==", "!="],
    &["<", ">", "<=", ">="],
    &["<<", ">>"],
    &["+", "-"],
];
/// The first of those that group from the left.
const FROM_LEFT: usize = 2;
/// The same of the operators that are left, the second those of one side.
const TIMES: usize = OPERATORS.len();
const UNARY: usize = TIMES + 1;
/// Of what has no operator, and of one beside which there is none.
const WHOLE: usize = UNARY + 1;

/// What is between an opening parenthesis or bracket and where the text has got to.
struct Group {
    start: usize,
    /// Whether it holds no more than an expression: no arguments, and no condition.
    is_loose: bool,
    /// How tightly what binds least in it does.
    least: usize,
}

/// The same GLSL, minified: each expression is worked out as before.
pub fn without_needless(glsl: &str) -> String {
    declarations(glsl).map(of_declaration).collect()
}

fn of_declaration(text: &str) -> String {
    // Lines of the preprocessor end with their line.
    if text.contains('#') {
        return text.to_owned();
    }
    let tokens = joined(text);
    let mut is_kept = vec![true; tokens.len()];
    for (start, end) in needless_braces(&tokens) {
        (is_kept[start], is_kept[end]) = (false, false);
    }
    let mut groups = vec![Group { start: 0, is_loose: false, least: WHOLE }];
    for (i, token) in tokens.iter().enumerate() {
        match &token[..] {
            "(" | "[" => {
                let before = i.checked_sub(1).map_or("", |before| &tokens[before]);
                let is_loose = token == "(" && (before == "return" || !ends_value(before));
                groups.push(Group { start: i, is_loose, least: WHOLE });
            }
            ")" | "]" => {
                let Some(group) = groups.pop() else { continue };
                let after = tokens.get(i + 1).map_or("", |after| &after[..]);
                let left = group.start.checked_sub(1).and_then(|before| binding(&tokens, before));
                let is_free = left.is_none_or(|left| group.least > left)
                    && binding(&tokens, i + 1)
                        .is_none_or(|right| group.least >= right.max(FROM_LEFT))
                    && ![".", "["].contains(&after);
                if let Some(around) = groups.last_mut().filter(|_| group.is_loose && is_free) {
                    (is_kept[group.start], is_kept[i]) = (false, false);
                    around.least = around.least.min(group.least);
                }
            }
            _ => {
                if let (Some(group), Some(own)) = (groups.last_mut(), binding(&tokens, i)) {
                    group.least = group.least.min(own);
                }
            }
        }
    }
    let kept = tokens.iter().zip(is_kept).filter_map(|(token, is_kept)| is_kept.then_some(token));
    let mut short = String::new();
    for token in kept {
        let token = without_zeros(token);
        let is_number = token.len() > 1 && token.starts_with('.');
        let would_join = (ends_word(&short) && (is_number || token.starts_with(is_word)))
            || (short.ends_with('-') && token.starts_with('-'));
        if would_join {
            short.push(' ');
        }
        short += token;
    }
    short
}

/// Where braces are around one statement alone.
fn needless_braces(tokens: &[String]) -> Vec<(usize, usize)> {
    let mut all = Vec::new();
    // Whether what is between the last parentheses is a condition.
    let mut conditions = Vec::new();
    let mut is_condition = false;
    for (i, token) in tokens.iter().enumerate() {
        let before = i.checked_sub(1).map_or("", |before| &tokens[before]);
        match &token[..] {
            "(" => conditions.push(before == "if" || before == "while"),
            ")" => is_condition = conditions.pop().unwrap_or(false),
            "{" if before == "else" || (before == ")" && is_condition) => {
                let is_end = |token: &String| [";", "{", "}"].contains(&&token[..]);
                let ends = (i + 1..tokens.len()).filter(|&at| is_end(&tokens[at])).take(2);
                // Else what follows might be taken for that one's.
                let is_plain = tokens.get(i + 1).is_some_and(|next| next != "if");
                if let [first, second] = ends.collect::<Vec<_>>()[..]
                    && is_plain
                    && (&tokens[first][..], &tokens[second][..]) == (";", "}")
                {
                    all.push((i, second));
                }
            }
            _ => {}
        }
    }
    all
}

/// A number without zeros that it can do without; other tokens as they are.
fn without_zeros(token: &str) -> &str {
    let is_number = token.starts_with(|c: char| c.is_ascii_digit());
    match token.split_once('.') {
        Some((whole, "0")) if is_number => &token[..=whole.len()],
        Some(("0", part)) if is_number && !part.is_empty() => &token[1..],
        _ => token,
    }
}

/// How tightly the token binds; `None` where it is no operator.
fn binding(tokens: &[String], i: usize) -> Option<usize> {
    let token = &tokens.get(i)?[..];
    let before = i.checked_sub(1).map_or("", |before| &tokens[before]);
    match token {
        "!" | "~" => Some(UNARY),
        "-" if before == "return" || !ends_value(before) => Some(UNARY),
        "*" | "/" | "%" => Some(TIMES),
        _ => OPERATORS.iter().position(|operators| operators.contains(&token)),
    }
}

/// Whether an operator after that token has something on its left, and a parenthesis arguments.
fn ends_value(token: &str) -> bool {
    token == ")" || token == "]" || ends_word(token)
}

fn ends_word(text: &str) -> bool {
    text.ends_with(is_word)
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Tokens without spaces, with operators and numbers whole.
fn joined(text: &str) -> Vec<String> {
    const PAIRS: [&str; 9] = ["<<", ">>", "<=", ">=", "==", "!=", "&&", "||", "^^"];
    let mut all: Vec<String> = Vec::new();
    let mut may_join = false;
    for token in tokens(text) {
        if token.trim().is_empty() {
            may_join = false;
            continue;
        }
        let starts_number = |text: &str| text.starts_with(|c: char| c.is_ascii_digit());
        let is_exponent = |number: &str| starts_number(number) && number.ends_with(['e', '-']);
        match all.last_mut().filter(|_| may_join) {
            Some(last)
                if PAIRS.contains(&[last, token].concat().as_str())
                    || (last == "." && starts_number(token))
                    || (is_exponent(last) && (token == "-" || last.ends_with('-'))) =>
            {
                *last += token;
            }
            _ => all.push(token.to_owned()),
        }
        may_join = true;
    }
    all
}
