//! Errors as people read them.

/// An error and its causes in one line. A cause that says what its error has just said is left out.
pub fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(cause) = source {
        let said = cause.to_string();
        if !text.ends_with(&said) {
            text.push_str(": ");
            text.push_str(&said);
        }
        source = cause.source();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt;

    #[derive(Debug)]
    struct Told(&'static str, Option<Box<Told>>);

    impl fmt::Display for Told {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str(self.0)
        }
    }

    impl std::error::Error for Told {
        fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
            Some(self.1.as_deref()?)
        }
    }

    #[test]
    fn causes_follow_and_none_is_told_twice() {
        let because = |text, cause| Told(text, Some(Box::new(cause)));
        let last = || Told("no space left", None);
        assert_eq!(chain(&last()), "no space left");
        let twice = because("cannot write: no space left", last());
        assert_eq!(
            chain(&because("cannot apply", twice)),
            "cannot apply: cannot write: no space left"
        );
    }
}
