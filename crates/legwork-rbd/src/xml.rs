//! The elements of a URDF or an MJCF and their attributes, each with its place in the text.

use std::borrow::Cow;
use std::collections::BTreeMap;

use roxmltree::{Attribute, Document, Error, Node};

use crate::error::ModelError;
use crate::read::Source;
use crate::words::{list, one_line, quoted};

/// A language of robots in XML.
pub(crate) struct Language {
    name: &'static str,
    /// What the outermost element is called; the first name is that of a robot's own file.
    roots: &'static [&'static str],
    holds: &'static str,
    /// How deep elements may be nested.
    depth: usize,
}

/// Elements of a link's material are nested 5 deep, those of a simulator's plugin little deeper.
pub(crate) const URDF: Language =
    Language { name: "URDF", roots: &["robot"], holds: "<robot> with links and joints", depth: 100 };

/// Bodies are nested as deep as a robot's longest chain.
pub(crate) const MJCF: Language =
    Language { name: "MJCF", roots: &["mujoco", "mujocoinclude"], holds: "<mujoco> with a <worldbody>", depth: 1000 };

const XACRO: &str = "holds xacro macros; expand them first (xacro robot.xacro > robot.urdf)";

/// The text, with an XML declaration that stands behind blank lines or comments made blank, as other readers of URDF let it
/// stand there.
pub(crate) fn lenient(text: &str) -> Cow<'_, str> {
    let Some(start) = text.find("<?xml ") else { return Cow::Borrowed(text) };
    let Some(length) = text[start..].find("?>").filter(|_| start > 0 && &text[..start] != "\u{feff}") else {
        return Cow::Borrowed(text);
    };
    let end = start + length + 2;
    let blank: String = text[start..end].chars().map(|c| if c == '\n' { '\n' } else { ' ' }).collect();
    Cow::Owned(format!("{}{blank}{}", &text[..start], &text[end..]))
}

/// The text without what other readers of URDF let pass, and what was mended, one sentence each: a prefix that nothing declares is declared,
/// and of two attributes with one name the second is taken out.
pub(crate) fn mended(text: &str) -> (String, Vec<String>) {
    let (mut text, mut warnings) = (text.to_owned(), Vec::new());
    while let Some((mended, warning)) = Document::parse(&text).err().and_then(|error| without(&error, &text)) {
        text = mended;
        warnings.push(warning);
    }
    (text, warnings)
}

/// The text without what `error` found, and a sentence that tells of it.
fn without(error: &Error, text: &str) -> Option<(String, String)> {
    let line = error.pos().row;
    match error {
        Error::UnknownNamespace(prefix, _) if prefix != "xacro" => {
            let at = text.find("<robot")? + "<robot".len();
            let warning = format!("line {line}: the prefix of {prefix}:… is not declared; what has it is ignored");
            Some((format!("{} xmlns:{prefix}=\"{prefix}\"{}", &text[..at], &text[at..]), warning))
        }
        Error::DuplicatedAttribute(name, position) => {
            let begin: usize = text.split_inclusive('\n').take(position.row as usize - 1).map(str::len).sum();
            let at = begin + text[begin..].char_indices().nth(position.col as usize - 1)?.0;
            let value = at + text[at..].find(['"', '\''])?;
            let quote = text[value..].chars().next()?;
            let end = value + 1 + text[value + 1..].find(quote)? + 1;
            let blank: String = text[at..end].chars().map(|c| if c == '\n' { '\n' } else { ' ' }).collect();
            let warning = format!("line {line}: a second {name} in one element is ignored");
            Some((format!("{}{blank}{}", &text[..at], &text[end..]), warning))
        }
        _ => None,
    }
}

/// The text with blanks for its comments, which may hold what XML forbids there, and for an XML declaration as in [`lenient`].
pub(crate) fn without_comments(text: &str) -> Cow<'_, str> {
    if !text.contains("<!--") {
        return lenient(text);
    }
    let (mut out, mut rest) = (String::with_capacity(text.len()), text);
    while let Some((start, length)) =
        rest.find("<!--").and_then(|start| Some((start, rest[start + 4..].find("-->")? + 7)))
    {
        out += &rest[..start];
        // Byte for byte, so that places stay where they are.
        out.extend(rest[start..start + length].bytes().map(|byte| if byte == b'\n' { '\n' } else { ' ' }));
        rest = &rest[start + length..];
    }
    out += rest;
    Cow::Owned(lenient(&out).into_owned())
}

/// The elements of a text that holds a robot.
pub(crate) fn parse<'a>(text: &'a str, source: &Source, language: &Language) -> Result<Document<'a>, ModelError> {
    let Language { name, roots, holds, depth: most } = language;
    if text.trim().is_empty() {
        return Err(source.syntax(None, format!("is empty; it should hold a {holds}")));
    }
    if !roots.iter().any(|root| text.contains(&format!("<{root}"))) {
        return Err(source.syntax(None, format!("no <{}> element; this is not {name}", roots[0])));
    }
    let document = Document::parse(text).map_err(|error| unreadable(&error, text, source, language))?;
    let mut depths = Vec::new();
    for node in document.descendants() {
        let depth = node.parent().map_or(0, |parent| 1 + depths[parent.id().get_usize()]);
        depths.push(depth);
        let line = || source.line(node.range().start);
        if depth > *most {
            let message = format!("elements are nested more than {most} deep, which no {name} needs");
            return Err(source.syntax(line(), message));
        }
        if node.is_element() && written_name(node).starts_with("xacro:") {
            return Err(source.syntax(line(), XACRO));
        }
    }
    let root = document.root_element();
    if !roots.contains(&written_name(root)) {
        let found = written_name(root);
        let message = format!("the outermost element is <{found}>; that of a {name} is <{}>", roots[0]);
        return Err(source.syntax(source.line(root.range().start), message));
    }
    Ok(document)
}

fn unreadable(error: &Error, text: &str, source: &Source, language: &Language) -> ModelError {
    let (line, name) = (Some(error.pos().row as usize), language.name);
    match error {
        Error::UnknownNamespace(prefix, _) if prefix == "xacro" => source.syntax(line, XACRO),
        Error::UnknownNamespace(prefix, _) => {
            let root = language.roots[0];
            let message = format!("the prefix of {prefix}:… is not declared; add xmlns:{prefix}=\"…\" to <{root}>");
            source.syntax(line, message)
        }
        Error::DtdDetected => {
            let line = text.find("<!DOCTYPE").and_then(|at| source.line(at));
            source.syntax(line, "holds a document type (<!DOCTYPE …>), which is not read; take it out")
        }
        Error::UnclosedRootNode | Error::UnexpectedEndOfStream => {
            source.syntax(None, format!("cannot be read as {name}: the text ends within an element"))
        }
        _ => source.syntax(line, format!("cannot be read as {name}: {error}")),
    }
}

/// The name of an element as it is written, with its prefix.
fn written_name<'a>(node: Node<'a, 'a>) -> &'a str {
    let tag = &node.document().input_text()[node.range()][1..];
    &tag[..tag.find(|c: char| c.is_ascii_whitespace() || c == '/' || c == '>').unwrap_or(tag.len())]
}

/// An element of a link, of a joint or of the robot.
#[derive(Clone, Copy)]
pub(crate) struct Element<'a> {
    node: Node<'a, 'a>,
    /// What messages call the link or joint.
    subject: &'a str,
    source: &'a Source<'a>,
}

impl<'a> Element<'a> {
    pub(crate) fn root(document: &'a Document<'a>, source: &'a Source<'a>) -> Self {
        Self { node: document.root_element(), subject: "robot", source }
    }

    /// The element as one of another subject.
    pub(crate) fn of(self, subject: &'a str) -> Self {
        Self { subject, ..self }
    }

    pub(crate) fn name(&self) -> &'a str {
        written_name(self.node)
    }

    /// The name of its file.
    pub(crate) fn file(&self) -> &'a str {
        self.source.file()
    }

    pub(crate) fn line(&self) -> Option<usize> {
        self.source.line(self.node.range().start)
    }

    pub(crate) fn invalid(&self, problem: impl Into<String>) -> ModelError {
        self.source.invalid(self.line(), self.subject, problem)
    }

    pub(crate) fn children(&self) -> impl Iterator<Item = Self> + use<'a> {
        let element = *self;
        self.node.children().filter(Node::is_element).map(move |node| Self { node, ..element })
    }

    /// The child of this name, of which there may be one.
    pub(crate) fn child(&self, name: &str) -> Result<Option<Self>, ModelError> {
        let mut named = self.children().filter(|child| child.name() == name);
        let first = named.next();
        match named.next() {
            Some(second) => Err(second.invalid(format!("a second <{name}>; give one"))),
            None => Ok(first),
        }
    }

    /// The child of this name, which there has to be.
    pub(crate) fn needed(&self, name: &str) -> Result<Self, ModelError> {
        self.child(name)?.ok_or_else(|| self.invalid(format!("<{name}> is missing in <{}>", self.name())))
    }

    fn attributes(&self) -> impl Iterator<Item = Attribute<'a, 'a>> {
        // One with a prefix is someone's extension.
        self.node.attributes().filter(|attribute| attribute.namespace().is_none())
    }

    /// The text of an attribute.
    pub(crate) fn get(&self, key: &str) -> Option<&'a str> {
        self.attribute(key).map(|attribute| attribute.value())
    }

    /// That the attribute's text is not what is needed.
    pub(crate) fn refused_at(&self, key: &str, needed: &str) -> ModelError {
        self.attribute(key).map_or_else(|| self.missing(key), |attribute| self.refused(&attribute, needed))
    }

    fn attribute(&self, key: &str) -> Option<Attribute<'a, 'a>> {
        self.attributes().find(|attribute| attribute.name() == key)
    }

    pub(crate) fn has(&self, key: &str) -> bool {
        self.attribute(key).is_some()
    }

    /// The text of an attribute that there has to be.
    pub(crate) fn text(&self, key: &str) -> Result<&'a str, ModelError> {
        let attribute = self.attribute(key);
        attribute.map(|attribute| attribute.value()).ok_or_else(|| self.missing(key))
    }

    fn missing(&self, key: &str) -> ModelError {
        self.invalid(format!("{} {key} is missing", self.name()))
    }

    /// A number, which may be infinite.
    pub(crate) fn extended(&self, key: &str) -> Result<Option<f64>, ModelError> {
        let Some(attribute) = self.attribute(key) else { return Ok(None) };
        match attribute.value().trim().parse::<f64>() {
            Ok(value) if !value.is_nan() => Ok(Some(value)),
            _ => Err(self.refused(&attribute, "a number such as 0.5 is needed")),
        }
    }

    pub(crate) fn number(&self, key: &str) -> Result<Option<f64>, ModelError> {
        let value = self.extended(key)?;
        match self.attribute(key) {
            Some(attribute) if value.is_some_and(f64::is_infinite) => {
                Err(self.refused(&attribute, "a finite number is needed"))
            }
            _ => Ok(value),
        }
    }

    pub(crate) fn needed_number(&self, key: &str) -> Result<f64, ModelError> {
        self.number(key)?.ok_or_else(|| self.missing(key))
    }

    /// Numbers between blanks.
    pub(crate) fn numbers<const N: usize>(&self, key: &str) -> Result<Option<[f64; N]>, ModelError> {
        let Some(attribute) = self.attribute(key) else { return Ok(None) };
        let parsed: Result<Vec<f64>, _> = attribute.value().split_whitespace().map(str::parse).collect();
        let numbers = parsed.ok().and_then(|numbers| <[f64; N]>::try_from(numbers).ok());
        match numbers.filter(|numbers| numbers.iter().all(|number| number.is_finite())) {
            Some(numbers) => Ok(Some(numbers)),
            None => Err(self.refused(&attribute, &format!("{N} finite numbers with blanks between them are needed"))),
        }
    }

    pub(crate) fn needed_numbers<const N: usize>(&self, key: &str) -> Result<[f64; N], ModelError> {
        self.numbers(key)?.ok_or_else(|| self.missing(key))
    }

    fn refused(&self, attribute: &Attribute, needed: &str) -> ModelError {
        let (line, value) = (self.source.line(attribute.range().start), quoted(attribute.value()));
        let problem = format!("{} {} is {value}; {needed}", self.name(), attribute.name());
        self.source.invalid(line, self.subject, problem)
    }
}

/// What stands in a file and has no meaning there: misspelled, or someone's own.
#[derive(Default)]
pub(crate) struct Ignored(BTreeMap<String, Place>);

/// Where it stands first, and how often.
struct Place {
    line: Option<usize>,
    subject: String,
    count: usize,
    known: String,
}

impl Ignored {
    /// Takes note of all children and attributes of `element` but those that are known.
    pub(crate) fn note(&mut self, element: &Element, children: &[&str], keys: &[&str]) {
        for child in element.children().filter(|child| !child.name().contains(':') && !children.contains(&child.name()))
        {
            self.add(format!("<{}> in <{}>", child.name(), element.name()), child.line(), element.subject, children);
        }
        for attribute in element.attributes().filter(|attribute| !keys.contains(&attribute.name())) {
            let line = element.source.line(attribute.range().start);
            self.add(format!("{} {}", element.name(), attribute.name()), line, element.subject, keys);
        }
    }

    fn add(&mut self, what: String, line: Option<usize>, subject: &str, known: &[&str]) {
        let place = || Place { line, subject: subject.to_owned(), count: 0, known: list(known) };
        self.0.entry(one_line(&what, 100)).or_insert_with(place).count += 1;
    }

    /// A sentence for each kind, in the order of the file.
    pub(crate) fn warnings(self) -> Vec<String> {
        let mut kinds: Vec<_> = self.0.into_iter().collect();
        kinds.sort_by_key(|(_, place)| place.line);
        let sentence = |(what, Place { line, subject, count, known })| {
            let line = line.map_or_else(String::new, |line| format!(" (line {line})"));
            let more = if count > 1 { format!(" and {} more", count - 1) } else { String::new() };
            let known = if known.is_empty() { String::new() } else { format!("; known are {known}") };
            format!("{subject}{line}{more}: {what} is ignored{known}")
        };
        kinds.into_iter().map(sentence).collect()
    }
}
