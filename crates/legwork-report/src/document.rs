//! Pages of chapters with figures, for what is more than a run: complete in themselves, in light, dark and print.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::charts::svg::{self, Drawing};
use crate::{NARROW, WIDE, file_name};

const DARK: &str = include_str!("charts/dark.css");
const PAGE_STYLE: &str = include_str!("page.css");

/// The page may run what it holds and load nothing.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

/// A page with the files of its figures.
#[derive(Clone, Debug)]
pub struct Page {
    /// The page, complete in itself.
    pub html: String,
    /// Name and text of each figure as an SVG file.
    pub figures: Vec<(String, String)>,
}

/// A part of a page with a heading.
pub(crate) struct Section {
    pub(crate) title: String,
    pub(crate) body: Markup,
}

/// Sections under one heading.
pub(crate) struct Chapter {
    pub(crate) title: String,
    /// What stands before the first section.
    pub(crate) lead: Markup,
    pub(crate) sections: Vec<Section>,
}

/// The figures of a page, numbered in the order in which they are drawn.
#[derive(Default)]
pub(crate) struct Figures {
    files: Vec<(String, String)>,
}

impl Figures {
    /// A figure that `draw` makes at any width [px]; its file is called after `name`.
    pub(super) fn add(&mut self, name: &str, title: &str, caption: &str, draw: impl Fn(f64) -> Drawing) -> Markup {
        let wide = draw(WIDE);
        let number = self.files.len() + 1;
        let name = file_name(name);
        let taken = self.files.iter().any(|(other, _)| *other == format!("{name}.svg"));
        let file = if taken { format!("{name}-{number}.svg") } else { format!("{name}.svg") };
        self.files.push((file, wide.standalone(title)));
        html! {
            figure {
                (wide.inline("wide"))
                (draw(NARROW).inline("narrow"))
                figcaption { b { "Figure " (number) ". " (title) "." } " " (caption) }
            }
        }
    }
}

/// A page of `chapters` with their contents.
pub(crate) fn page(title: &str, lead: &Markup, chapters: &[Chapter], figures: Figures) -> Page {
    let id = |chapter: usize, section: usize| format!("c{}-{}", chapter + 1, section + 1);
    let contents = html! {
        nav aria-label="Contents" {
            @for (number, chapter) in chapters.iter().enumerate() {
                div {
                    a.run href={ "#c" (number + 1) } { (chapter.title) }
                    @if chapters.len() > 1 || chapter.sections.len() > 1 {
                        ul {
                            @for (index, section) in chapter.sections.iter().enumerate() {
                                li { a href={ "#" (id(number, index)) } { (section.title) } }
                            }
                        }
                    }
                }
            }
        }
    };
    let main = html! {
        header.top { h1 { (title) } (lead) }
        @for (number, chapter) in chapters.iter().enumerate() {
            article id={ "c" (number + 1) } {
                header { h2 { (chapter.title) } (chapter.lead) }
                @for (index, section) in chapter.sections.iter().enumerate() {
                    section id=(id(number, index)) { h3 { (section.title) } (section.body) }
                }
            }
        }
    };
    Page { html: frame(title, "#c1", &contents, &main, ""), figures: figures.files }
}

/// The frame of every page; `script` runs in it, `skip` is where a keyboard's first step leads.
pub(super) fn frame(title: &str, skip: &str, contents: &Markup, main: &Markup, script: &str) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="generator" content={ "legwork " (env!("CARGO_PKG_VERSION")) };
                link rel="icon" href="data:,";
                title { (title) }
                style { (PreEscaped(style())) }
            }
            body {
                a.skip href=(skip) { "To the content" }
                (contents)
                main { (main) }
                @if !script.is_empty() { script { (PreEscaped(script)) } }
            }
        }
    };
    page.into_string()
}

fn style() -> String {
    format!(
        ":root {{\n{}}}\n@media screen and (prefers-color-scheme: dark) {{\n:root {{\n{DARK}}}\n}}\n{}{PAGE_STYLE}",
        svg::LIGHT,
        svg::FIGURE_STYLE
    )
}
