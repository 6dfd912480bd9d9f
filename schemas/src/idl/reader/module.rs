//! Modules.

use super::super::token::Token;
use super::{Parsed, Reader};

impl Reader<'_> {
    /// `module name { … }`, without its `;`.
    pub(super) fn module(&mut self) -> Parsed<()> {
        self.advance();
        let (name, at) = self.identifier("the module")?;
        self.expect("{", "a module has its definitions in braces")?;
        self.within(|reader| {
            let (outer, prefix) = (reader.scope, reader.prefix.clone());
            reader.enter_module(&name, at);
            if reader.is("}") {
                let message = format!("the module `{name}` is empty");
                reader.error(
                    "idl-syntax",
                    at,
                    message,
                    "write a definition into it, or leave it out",
                );
            }
            while !reader.is("}") && reader.token != Token::End {
                if reader.definition().is_err() {
                    reader.recover();
                }
            }
            let closed = reader.expect("}", &format!("close the module `{name}`"));
            reader.scope = outer;
            reader.prefix = prefix;
            closed
        })
    }
}
