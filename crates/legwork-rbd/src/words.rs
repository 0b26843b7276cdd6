//! Words of messages. What others wrote stands in them cut and escaped, so that a message is one line that can be read.

use std::borrow::Cow;

/// Most characters of a message's place, and of what it says.
pub const PLACE: usize = 200;
/// See [`PLACE`].
pub const PROBLEM: usize = 450;

/// Most characters of a text that is quoted.
const QUOTED: usize = 60;

/// Most characters of names in a row, but for the last of them.
const LISTED: usize = 280;

/// A text that was found, between quotation marks.
pub fn quoted(text: &str) -> String {
    format!("\"{}\"", shortened(&shortened(text, QUOTED).escape_debug().to_string(), QUOTED))
}

/// Names in a row: `a, b, c and 4997 more`.
pub fn list(names: impl IntoIterator<Item = impl AsRef<str>>) -> String {
    let (mut text, mut length) = (String::new(), 0);
    let mut names = names.into_iter();
    while let Some(name) = names.next() {
        let name = one_line(name.as_ref(), QUOTED);
        length += name.chars().count() + 2;
        if !text.is_empty() && length > LISTED {
            return format!("{text} and {} more", 1 + names.count());
        }
        text += if text.is_empty() { "" } else { ", " };
        text += &name;
    }
    text
}

/// The text in one line of at most `most` characters: without its middle where it is longer, for its end mostly says what
/// would be valid; characters that control a terminal are escaped.
pub fn one_line(text: &str, most: usize) -> String {
    let escape = |c: char| if c.is_control() { c.escape_debug().to_string() } else { c.to_string() };
    let escaped: String = shortened(text, most).chars().map(escape).collect();
    shortened(&escaped, most).into_owned()
}

fn shortened(text: &str, most: usize) -> Cow<'_, str> {
    if text.char_indices().nth(most).is_none() {
        return text.into();
    }
    let dots = "...";
    let (begin, end) = ((most - dots.len()) * 2 / 3, (most - dots.len()).div_ceil(3));
    let at = |found: Option<(usize, char)>| found.map_or(0, |(at, _)| at);
    let [begin, end] = [at(text.char_indices().nth(begin)), at(text.char_indices().nth_back(end - 1))];
    format!("{}{dots}{}", &text[..begin], &text[end..]).into()
}

/// Whether `name` is what the `pattern` says, in which each `*` stands for any characters or none. Allocates nothing.
pub fn matches(pattern: &str, name: &str) -> bool {
    let Some((head, mut rest)) = pattern.split_once('*') else { return pattern == name };
    let Some(mut name) = name.strip_prefix(head) else { return false };
    while let Some((part, after)) = rest.split_once('*') {
        // The first place will do: what follows may begin anywhere.
        let Some(at) = name.find(part) else { return false };
        (name, rest) = (&name[at + part.len()..], after);
    }
    name.ends_with(rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_lose_their_middle() {
        assert_eq!(shortened("0123456789", 10), "0123456789");
        assert_eq!(shortened("0123456789x", 10), "0123...89x");
        for most in 4..40 {
            let cut = shortened("äöü∑ρ0123456789äöü∑ρ0123456789äöü∑ρ0123456789", most);
            assert_eq!(cut.chars().count(), most.min(45), "{cut}");
        }
    }

    #[test]
    fn a_quoted_text_is_short_and_cannot_control_a_terminal() {
        assert_eq!(quoted("a\n\"b\u{1b}[31m"), r#""a\n\"b\u{1b}[31m""#);
        for text in ["ä".repeat(10_000_000), "\u{1b}".repeat(5000)] {
            assert_eq!(quoted(&text).chars().count(), 62);
        }
        assert_eq!(one_line("a\nb \u{7f} \"c\" ∑", 40), "a\\nb \\u{7f} \"c\" ∑");
        assert_eq!(one_line(&"\0".repeat(100), 50).chars().count(), 50);
    }

    #[test]
    fn many_names_are_counted() {
        assert_eq!(list(["com", "torso", "left_shank"]), "com, torso, left_shank");
        assert_eq!(list([""; 0]), "");
        let names = (0..5000).map(|k| format!("link_{k}"));
        let text = list(names);
        assert!(text.starts_with("link_0, link_1, ") && text.chars().count() < 300, "{text}");
        let (shown, rest) = text.rsplit_once(" and ").expect("not all fit");
        assert_eq!(rest, format!("{} more", 5000 - shown.split(", ").count()));
        assert!(list(["x".repeat(4000)]).chars().count() == 60);
    }

    #[test]
    fn a_star_stands_for_anything_or_nothing() {
        for (pattern, name, holds) in [
            ("knee", "knee", true),
            ("knee", "knees", false),
            ("*_wrist_*", "l_wrist_yaw", true),
            ("*_wrist_*", "l_wrist", false),
            ("l_*", "l_", true),
            ("*", "", true),
            ("a*b*c", "aXbYbZc", true),
            ("a*b*c", "ac", false),
            ("ab*ba", "aba", false),
        ] {
            assert_eq!(matches(pattern, name), holds, "{pattern} {name}");
        }
    }
}
