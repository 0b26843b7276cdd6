//! The text of a URDF: parsed by `urdf-rs`, after a look at what that would not survive or explain.

use crate::error::ModelError;
use crate::read::Source;

/// The parser recurses; a link's material takes 5.
const MAX_DEPTH: usize = 100;

/// Whether a xacro element is left outside comments, and how deep elements are nested.
fn scan(text: &str) -> (bool, usize) {
    let (mut xacro, mut depth, mut deepest) = (false, 0_usize, 0);
    let mut rest = text;
    while let Some(start) = rest.find('<') {
        rest = &rest[start..];
        if let Some(comment) = rest.strip_prefix("<!--") {
            rest = comment.find("-->").map_or("", |end| &comment[end..]);
            continue;
        }
        xacro |= rest.starts_with("<xacro:");
        let Some(end) = rest.find('>') else { break };
        if rest.starts_with("</") {
            depth = depth.saturating_sub(1);
        } else if !rest.starts_with("<?") && !rest.starts_with("<!") {
            depth += 1;
            deepest = deepest.max(depth);
            if rest[..end].ends_with('/') {
                depth -= 1;
            }
        }
        rest = &rest[1..];
    }
    (xacro, deepest)
}

pub(crate) fn parse(text: &str, source: &Source) -> Result<urdf_rs::Robot, ModelError> {
    if text.trim().is_empty() {
        return Err(source.syntax(None, "is empty; it should hold a <robot> with links and joints"));
    }
    if !text.contains("<robot") {
        return Err(source.syntax(None, "no <robot> element; this is not URDF"));
    }
    let (xacro, depth) = scan(text);
    if depth > MAX_DEPTH {
        let message = format!("elements are nested {depth} deep; URDF needs no more than {MAX_DEPTH}");
        return Err(source.syntax(None, message));
    }
    if xacro {
        return Err(source.syntax(None, "holds xacro macros; expand them first (xacro robot.xacro > robot.urdf)"));
    }
    let text = text.trim_start_matches('\u{feff}');
    urdf_rs::read_from_string(text).map_err(|error| source.syntax(None, format!("cannot be read as URDF: {error}")))
}

/// The line, from one, where the element with this name begins. The parser keeps no places, so the text is searched.
pub(crate) fn element_line(text: &str, element: &str, name: &str) -> Option<usize> {
    let opening = format!("<{element}");
    let (double, single) = (format!("name=\"{name}\""), format!("name='{name}'"));
    for (start, _) in text.match_indices(&opening) {
        let rest = &text[start + opening.len()..];
        let tag = &rest[..rest.find('>')?];
        if tag.starts_with(char::is_whitespace) && (tag.contains(&double) || tag.contains(&single)) {
            return Some(1 + text[..start].matches('\n').count());
        }
    }
    None
}
