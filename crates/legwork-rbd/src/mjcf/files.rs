//! The texts of an MJCF: the file and what it includes, each as a tree of elements.

use std::collections::HashMap;

use roxmltree::Document;

use crate::error::ModelError;
use crate::file::{self, Unread};
use crate::read::Source;
use crate::words::quoted;
use crate::xml::{Element, MJCF, parse, without_comments};

/// Reads a file by its path from the folder of the model's own file.
pub(crate) type ReadFile<'a> = &'a dyn Fn(&str) -> Result<Vec<u8>, Unread>;

/// A text with its name and the files that it includes.
pub(super) struct Text {
    name: String,
    /// The folder, from that of the model's own file.
    folder: String,
    text: String,
}

/// The model's own text, then the texts that are included, by the names under which they are.
pub(super) struct Texts {
    texts: Vec<Text>,
    included: HashMap<String, usize>,
}

impl Texts {
    pub(super) fn gather(text: &str, name: &str, read: ReadFile) -> Result<Self, ModelError> {
        let own = Text { name: name.to_owned(), folder: String::new(), text: without_comments(text).into_owned() };
        let mut gathered = Self { texts: vec![own], included: HashMap::new() };
        let mut next = 0;
        while next < gathered.texts.len() {
            gathered.add_included(next, name, read)?;
            next += 1;
        }
        Ok(gathered)
    }

    /// Reads the files that a text includes.
    fn add_included(&mut self, index: usize, own_name: &str, read: ReadFile) -> Result<(), ModelError> {
        let Text { name, folder, text } = &self.texts[index];
        let folder = folder.clone();
        let source = Source::new(name, text);
        let document = parse(text, &source, &MJCF)?;
        let mut found = Vec::new();
        let mut open = vec![Element::root(&document, &source)];
        while let Some(element) = open.pop() {
            if element.name() != "include" {
                open.extend(element.children());
                continue;
            }
            let element = element.of("include");
            let file = element.text("file")?.to_owned();
            if self.included.contains_key(&file) || found.iter().any(|text: &(String, Text)| text.0 == file) {
                return Err(
                    element.invalid(format!("file {} is included twice; a file may be included once", quoted(&file)))
                );
            }
            let (path, bytes) = read_either(&file, &folder, read)
                .map_err(|unread| element.invalid(format!("file {}: {unread}", quoted(&file))))?;
            let text =
                file::text(bytes).map_err(|unread| element.invalid(format!("file {}: {unread}", quoted(&file))))?;
            let folder = path.rfind(['/', '\\']).map_or(String::new(), |end| path[..=end].to_owned());
            let text = Text { name: beside(own_name, &path), folder, text: without_comments(&text).into_owned() };
            found.push((file, text));
        }
        for (file, text) in found {
            self.included.insert(file, self.texts.len());
            self.texts.push(text);
        }
        Ok(())
    }

    pub(super) fn sources(&self) -> Vec<Source<'_>> {
        self.texts.iter().map(|text| Source::new(&text.name, &text.text)).collect()
    }

    pub(super) fn documents(&self, sources: &[Source]) -> Result<Vec<Document<'_>>, ModelError> {
        self.texts.iter().zip(sources).map(|(text, source)| parse(&text.text, source, &MJCF)).collect()
    }
}

/// A file by its path from the model's own folder, or else from the folder of the text that names it.
fn read_either(file: &str, folder: &str, read: ReadFile) -> Result<(String, Vec<u8>), Unread> {
    match read(file) {
        Ok(bytes) => Ok((file.to_owned(), bytes)),
        Err(unread) if folder.is_empty() => Err(unread),
        Err(unread) => {
            let path = format!("{folder}{file}");
            read(&path).map(|bytes| (path, bytes)).map_err(|_| unread)
        }
    }
}

/// The name of a file at `path` from the folder of the file `own`.
fn beside(own: &str, path: &str) -> String {
    let folder = own.rfind(['/', '\\']).map_or("", |end| &own[..=end]);
    format!("{folder}{path}")
}

/// The elements of all texts, as if what is included stood where it is named.
pub(super) struct Tree<'a> {
    texts: &'a Texts,
    documents: &'a [Document<'a>],
    sources: &'a [Source<'a>],
}

impl<'a> Tree<'a> {
    pub(super) fn new(texts: &'a Texts, documents: &'a [Document<'a>], sources: &'a [Source<'a>]) -> Self {
        Self { texts, documents, sources }
    }

    pub(super) fn root(&self) -> Element<'a> {
        Element::root(&self.documents[0], &self.sources[0]).of("model")
    }

    /// The line of an element in the model's own file; none of what stands in another one.
    pub(super) fn own_line(&self, element: Element) -> Option<usize> {
        element.line().filter(|_| element.file() == self.sources[0].file())
    }

    /// The place of an element, to begin a sentence with.
    pub(super) fn at(&self, element: Element) -> String {
        let Some(line) = element.line() else { return String::new() };
        let own = self.own_line(element).is_some();
        if own { format!("line {line}: ") } else { format!("{}, line {line}: ", element.file()) }
    }

    /// The children of an element, in the order of the file.
    pub(super) fn children(&self, element: Element<'a>) -> Vec<Element<'a>> {
        let mut children = Vec::new();
        let mut open: Vec<_> = element.children().collect();
        open.reverse();
        while let Some(child) = open.pop() {
            if child.name() != "include" {
                children.push(child);
            } else if let Some(&index) = child.get("file").and_then(|file| self.texts.included.get(file)) {
                let root = Element::root(&self.documents[index], &self.sources[index]).of("model");
                let mut included: Vec<_> = root.children().collect();
                included.reverse();
                open.extend(included);
            }
        }
        children
    }

    /// The outermost elements of this name.
    pub(super) fn sections(&self, name: &str) -> Vec<Element<'a>> {
        self.children(self.root()).into_iter().filter(|section| section.name() == name).collect()
    }
}
