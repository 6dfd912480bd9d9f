//! A form as a whole file: canonical XML or YAML, with everything that the form keeps.

use super::place::{declaration, declared_prefix};
use super::{Form, Scope, Vocabulary, element_of, print_yaml, yaml_of};
use crate::xml::{self, Node};

/// How a profile is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// `rts:RtsProfile`, `rtc:RtcProfile`.
    Xml,
    /// `rtsProfile:`, `rtcProfile:`.
    Yaml,
}

/// What stands around the root element.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Around {
    /// Comments and instructions before it.
    pub before: Vec<Node>,
    /// Comments and instructions after it.
    pub after: Vec<Node>,
    /// Its name, when it is not the usual one.
    pub qname: Option<Box<str>>,
}

/// The text of a whole profile: one element or key a line, indented, in UTF-8. What it is printed from is the form alone.
///
/// XML has everything that was read, comments too; YAML has all but comments and the order of different elements.
pub fn format(form: &dyn Form, around: &Around, words: &Vocabulary, format: Format) -> String {
    match format {
        Format::Xml => xml::print(&around.tree(form, words)),
        Format::Yaml => print_yaml::document(words.key, &yaml_of(form, words)),
    }
}

impl Around {
    /// The element tree of a whole profile.
    pub fn tree(&self, form: &dyn Form, words: &Vocabulary) -> xml::Tree {
        let usual = format!("{}:{}", words.prefix(words.namespace), words.roots[0]);
        let qname = self.qname.as_deref().unwrap_or(&usual);
        let own = &form.extra().get().attributes;
        let fresh = !own.iter().any(|a| declared_prefix(&a.qname).is_some());
        let mut scope = Scope::default();
        if fresh {
            for (prefix, namespace) in words.prefixes {
                scope.declare(prefix, namespace);
            }
        }
        let qname = if fresh { usual.as_str() } else { qname };
        let mut root = element_of(form, (words.namespace, qname), &mut scope, words);
        if fresh {
            let made = words.prefixes.iter();
            let made = made.map(|(prefix, namespace)| declaration(prefix, namespace));
            root.attributes.splice(0..0, made);
        }
        xml::Tree {
            before: self.before.clone(),
            root,
            after: self.after.clone(),
        }
    }
}
