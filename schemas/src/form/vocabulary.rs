//! The names of one kind of profile, and a file opened as such.

use super::allowance::{Allowance, too_dense};
use super::read_xml::read_some;
use super::{Around, Form, Format, read_node, report_unknown};
use crate::diagnostic::{Finding, Report, Source};
use crate::span::{Span, Text};
use crate::{overlay, xml, yaml};

/// Names of one kind of profile.
#[derive(Debug)]
pub struct Vocabulary {
    /// `RTS Profile`.
    pub title: &'static str,
    /// Local names of the root element; the first is written.
    pub roots: &'static [&'static str],
    /// Namespace of the root element.
    pub namespace: &'static str,
    /// Root key in YAML.
    pub key: &'static str,
    /// Usual prefixes and their namespaces.
    pub prefixes: &'static [(&'static str, &'static str)],
    /// What other documents are, that are taken for this one: name of the root and advice.
    pub others: &'static [(&'static str, &'static str)],
}

impl Vocabulary {
    /// The usual prefix of a namespace.
    pub fn prefix(&self, namespace: &str) -> &'static str {
        let known = self.prefixes.iter().find(|(_, uri)| *uri == namespace);
        known.map_or("ns", |(prefix, _)| prefix)
    }

    /// True for a namespace that belongs to profiles of this kind.
    pub fn knows(&self, namespace: &str) -> bool {
        self.prefixes.iter().any(|(_, uri)| *uri == namespace)
    }

    fn advice(&self, root: &str, usual: impl Fn() -> String) -> String {
        let other = self.others.iter().find(|(name, _)| *name == root);
        other.map_or_else(usual, |(_, advice)| (*advice).to_owned())
    }

    fn wrong_element(&self, root: &xml::Element, source: &Source) -> Finding {
        let place = Some(source.place(root.span.start, root.span.end));
        let prefix = self.prefix(self.namespace);
        let finding = if self.roots.contains(&root.local()) {
            let message = format!("`{}` is in the namespace `{}`", root.qname, root.namespace);
            let help = format!(
                "declare `xmlns:{prefix}=\"{}\"` on the root element",
                self.namespace
            );
            Finding::error("wrong-namespace", message).help(help)
        } else {
            let message = format!("`<{}>` is not the root of an {}", root.qname, self.title);
            let usual = || {
                format!(
                    "the root of an {} is `<{prefix}:{}>`",
                    self.title, self.roots[0]
                )
            };
            Finding::error("wrong-root", message).help(self.advice(root.local(), usual))
        };
        finding.at(place)
    }

    fn empty(&self, source: &Source) -> Finding {
        let help = format!(
            "an {} starts with `<{}:{} …>` or `{}:`",
            self.title,
            self.prefix(self.namespace),
            self.roots[0],
            self.key
        );
        Finding::error("empty-file", format!("{} is empty", source.name()))
            .at(Some(source.place(0, 0)))
            .help(help)
    }

    fn wrong_key(&self, root: &yaml::Node, source: &Source) -> Finding {
        let key = root.entries().first().map(|(key, _)| key);
        let place = |span: Span| (!span.is_unknown()).then(|| source.place(span.start, span.end));
        let (message, place) = match key {
            Some(key) => (
                format!("`{}:` is not the root of an {}", key.value, self.title),
                place(key.span),
            ),
            None => (
                format!("an {} is a mapping, this is {}", self.title, root.kind()),
                place(root.span),
            ),
        };
        let usual = || format!("the root of an {} in YAML is `{}:`", self.title, self.key);
        let kind = root.get("kind").and_then(yaml::Node::text);
        let help = match kind.as_ref().map(Text::trimmed) {
            Some(kind) if kind != overlay::KIND => {
                format!("this is a `{kind}`; {}", usual())
            }
            _ => self.advice(key.map_or("", |key| &key.value), usual),
        };
        Finding::error("wrong-root", message).at(place).help(help)
    }
}

/// A file that is XML or YAML, and has the right root.
#[derive(Debug)]
pub struct Opened {
    /// The decoded text.
    pub source: Source,
    /// Name of the encoding that was found.
    pub encoding: &'static str,
    /// What was noticed.
    pub findings: Report,
    /// Its tree.
    pub tree: Tree,
}

/// The tree of a file.
#[derive(Debug)]
pub enum Tree {
    /// An XML document.
    Xml(xml::Tree),
    /// The value under the root key of a YAML document, and the place of the key.
    Yaml(yaml::Node, Span),
}

/// Opens a file; the format is seen from the content, never from the file's name.
///
/// # Errors
/// A report with one error when the file cannot be read at all: encoding, syntax, or another kind of document.
pub fn open(file_name: &str, bytes: &[u8], words: &Vocabulary) -> Result<Opened, Report> {
    let decoded = xml::decode(file_name, bytes).map_err(|finding| alone(*finding))?;
    let source = Source::new(file_name, decoded.text);
    let mut findings = Report::default();
    findings.findings.extend(decoded.warning);
    let start = source.text().trim_start();
    let tree = if start.is_empty() {
        return Err(alone(words.empty(&source)));
    } else if start.starts_with('<') {
        let tree = xml::parse_tree(source.text()).map_err(|error| alone(error.finding(&source)))?;
        let root = &tree.root;
        if *root.namespace != *words.namespace || !words.roots.contains(&root.local()) {
            findings.push(words.wrong_element(root, &source));
            return Err(findings);
        }
        Tree::Xml(tree)
    } else {
        let root = yaml::parse(&source).map_err(|finding| alone(*finding))?;
        if root.value == yaml::Value::Null {
            return Err(alone(words.empty(&source)));
        }
        let others = root.entries().iter().map(|(key, _)| key);
        let others: Vec<_> = others
            .filter(|key| key.value != words.key)
            .cloned()
            .collect();
        match root.take(words.key) {
            Ok((key, body)) => {
                for other in others.iter().filter(|other| !other.value.starts_with("x-")) {
                    let place = (!other.span.is_unknown())
                        .then(|| source.place(other.span.start, other.span.end));
                    let message = format!(
                        "`{}` stands beside `{}:` and was not read",
                        other.value, words.key
                    );
                    let finding = Finding::warning("unknown-element", message).at(place);
                    findings.push(finding.help("remove it, or move it into the profile"));
                }
                Tree::Yaml(body, key.span)
            }
            Err(root) => {
                findings.push(words.wrong_key(&root, &source));
                return Err(findings);
            }
        }
    };
    Ok(Opened {
        source,
        encoding: decoded.encoding,
        findings,
        tree,
    })
}

fn alone(finding: Finding) -> Report {
    Report {
        findings: vec![finding],
    }
}

impl Tree {
    /// Fills the form of the root; what it has no field for is reported.
    pub fn fill(
        self,
        form: &mut dyn Form,
        words: &Vocabulary,
        source: &Source,
        report: &mut Report,
    ) -> (Format, Around) {
        match self {
            Self::Xml(tree) => {
                let around = Around {
                    before: tree.before,
                    after: tree.after,
                    qname: Some(tree.root.qname.clone()),
                };
                let mut allowance = Allowance::of(source.text().len());
                read_some(tree.root, form, words, &mut allowance);
                if allowance.is_spent() {
                    report.push(too_dense());
                }
                report_unknown(form, words, source, report);
                (Format::Xml, around)
            }
            Self::Yaml(node, span) => {
                read_node(node, form, source, report);
                form.stand(span);
                (Format::Yaml, Around::default())
            }
        }
    }
}
