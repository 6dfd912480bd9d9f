//! Numbers, characters and strings.

use super::lexer::Lexed;
use super::token::Token;

/// Advice on fixed-point numbers.
pub(super) const FIXED: &str = "write it as a floating-point number, without `d`";

/// A number at the start of a text.
pub(super) fn number(text: &str) -> Lexed {
    let mut length = 0;
    let mut before = ' ';
    for c in text.chars() {
        let is_sign = matches!(c, '+' | '-') && matches!(before, 'e' | 'E') && !is_hex(text);
        if !(c.is_ascii_alphanumeric() || c == '.' || c == '_' || is_sign) {
            break;
        }
        length += c.len_utf8();
        before = c;
    }
    let word = &text[..length];
    let token = match word {
        _ if is_hex(word) => integer(&word[2..], 16, word),
        _ if word.contains('.') || word.contains(['e', 'E']) => float(word),
        _ if word.len() > 1 && word.starts_with('0') => integer(&word[1..], 8, word),
        _ => integer(word, 10, word),
    };
    (length, token)
}

fn is_hex(word: &str) -> bool {
    word.starts_with("0x") || word.starts_with("0X")
}

fn integer(digits: &str, radix: u32, word: &str) -> Result<Token, (String, &'static str)> {
    if digits.ends_with(['d', 'D']) && radix != 16 {
        return Err(("fixed-point numbers are not supported".to_owned(), FIXED));
    }
    if let Some(wrong) = digits.chars().find(|c| !c.is_digit(radix)) {
        let help = match radix {
            8 => "a number that begins with 0 is octal, of the digits 0 to 7",
            16 => "a number that begins with 0x is hexadecimal, of the digits 0 to 9 and a to f",
            _ => "a number has digits only: IDL knows no suffixes such as `L` or `f`",
        };
        return Err((
            format!("`{word}` is no number: `{wrong}` is no digit of it"),
            help,
        ));
    }
    if digits.is_empty() {
        return Err((format!("`{word}` is no number"), "digits must follow"));
    }
    u64::from_str_radix(digits, radix)
        .map(Token::Integer)
        .map_err(|_| {
            let message = format!("`{word}` is too large");
            (message, "the largest integer is 18446744073709551615")
        })
}

fn float(word: &str) -> Result<Token, (String, &'static str)> {
    if word.ends_with(['d', 'D']) {
        return Err(("fixed-point numbers are not supported".to_owned(), FIXED));
    }
    let is_plain = |c: char| c.is_ascii_digit() || matches!(c, '.' | 'e' | 'E' | '+' | '-');
    match word.parse::<f64>() {
        Ok(value) if value.is_finite() && word.chars().all(is_plain) => Ok(Token::Float(value)),
        Ok(_) => {
            let message = format!("`{word}` is too large");
            Err((message, "the largest `double` is about 1.8e308"))
        }
        Err(_) => {
            let message = format!("`{word}` is no number");
            Err((
                message,
                "a floating-point number is written as 1.5, .5 or 1e-3, without a suffix",
            ))
        }
    }
}

/// A character at the start of a text, wide with an `L` before it.
pub(super) fn character(text: &str) -> Lexed {
    let (wide, inside) = opened(text);
    let inside_length = end(inside, '\'');
    let Some(inside_length) = inside_length else {
        let message = "this character has no end".to_owned();
        let length = text.lines().next().map_or(1, str::len);
        return (length, Err((message, "end it with `'`")));
    };
    let length = text.len() - inside.len() + inside_length + 1;
    let characters = match unescape(&inside[..inside_length], wide) {
        Ok(characters) => characters,
        Err(wrong) => return (length, Err(wrong)),
    };
    let mut characters = characters.chars();
    let token = match (characters.next(), characters.next()) {
        (Some(one), None) if wide => Ok(Token::WChar(one)),
        (Some(one), None)
            if u32::from(one) < 256 && (one.is_ascii() || !inside.starts_with(one)) =>
        {
            Ok(Token::Char(one))
        }
        (Some(one), None) => {
            let message = format!(
                "`{one}` is no `char`: what its bytes are depends on the encoding of the file"
            );
            Err((
                message,
                "write its code as `\\x` and two digits, or a `wchar` as L'…'",
            ))
        }
        (None, _) => Err(("this character is empty".to_owned(), "write one character")),
        (Some(_), Some(_)) => {
            let message = "these are several characters".to_owned();
            Err((message, "a string stands in double quotes"))
        }
    };
    (length, token)
}

/// A string at the start of a text, wide with an `L` before it.
pub(super) fn string(text: &str) -> Lexed {
    let (wide, inside) = opened(text);
    let Some(inside_length) = end(inside, '"') else {
        let message = "this string does not end in its line".to_owned();
        let length = text.lines().next().map_or(1, str::len);
        return (
            length,
            Err((
                message,
                "end it with `\"`; strings that follow each other are one",
            )),
        );
    };
    let length = text.len() - inside.len() + inside_length + 1;
    let token =
        unescape(&inside[..inside_length], wide).and_then(|value| match value.contains('\0') {
            true => {
                let message = "this string has a character with the code 0".to_owned();
                Err((message, "strings end at the code 0: leave it out"))
            }
            false if wide => Ok(Token::WText(value)),
            false => Ok(Token::Text(value)),
        });
    (length, token)
}

/// Whether it is wide, and what follows the first quote.
fn opened(text: &str) -> (bool, &str) {
    let wide = text.starts_with('L');
    (wide, text.get(1 + usize::from(wide)..).unwrap_or_default())
}

/// Where the quote is that ends the text.
fn end(inside: &str, quote: char) -> Option<usize> {
    let mut is_escaped = false;
    for (at, c) in inside.char_indices() {
        match c {
            '\n' => return None,
            _ if is_escaped => is_escaped = false,
            '\\' => is_escaped = true,
            _ if c == quote => return Some(at),
            _ => {}
        }
    }
    None
}

fn unescape(text: &str, wide: bool) -> Result<String, (String, &'static str)> {
    const HELP: &str = "known are \\n \\t \\v \\b \\r \\f \\a \\\\ \\? \\' \\\" , octal \\ooo, hexadecimal \\xhh, and \\uhhhh in wide ones";
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find('\\') {
        out.push_str(&rest[..at]);
        rest = &rest[at + 1..];
        let first = rest.chars().next().unwrap_or(' ');
        let digits = |from: usize, most: usize, radix: u32| {
            let those = rest.get(from..).unwrap_or_default().chars();
            those.take(most).take_while(|c| c.is_digit(radix)).count()
        };
        let (from, count, radix, largest) = match first {
            '0'..='7' => (0, digits(0, 3, 8), 8, 0xff),
            'x' => (1, digits(1, 2, 16), 16, 0xff),
            'u' if wide => (1, digits(1, 4, 16), 16, 0xffff),
            _ => (0, 0, 10, 0),
        };
        let (length, value) = match first {
            _ if count > 0 => {
                let code =
                    u32::from_str_radix(&rest[from..from + count], radix).unwrap_or(u32::MAX);
                (
                    from + count,
                    char::from_u32(code).filter(|_| code <= largest),
                )
            }
            'n' => (1, Some('\n')),
            't' => (1, Some('\t')),
            'v' => (1, Some('\u{b}')),
            'b' => (1, Some('\u{8}')),
            'r' => (1, Some('\r')),
            'f' => (1, Some('\u{c}')),
            'a' => (1, Some('\u{7}')),
            '\\' | '?' | '\'' | '"' => (1, Some(first)),
            _ => (0, None),
        };
        let Some(value) = value else {
            let shown = &rest[..length.max(first.len_utf8()).min(rest.len())];
            return Err((format!("`\\{shown}` stands for no character here"), HELP));
        };
        out.push(value);
        rest = &rest[length..];
    }
    out.push_str(rest);
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(lexed: Lexed) -> String {
        match lexed.1 {
            Ok(token) => format!("{} {token:?}", lexed.0),
            Err((message, help)) => format!("{} {message} ({help})", lexed.0),
        }
    }

    #[test]
    fn numbers() {
        let texts = [
            "0",
            "017",
            "0x1F;",
            "0XaB",
            "18446744073709551615",
            "1.5;",
            ".5",
            "5.",
            "1e3",
            "1.e-3-1",
            "08",
            "1L",
            "18446744073709551616",
            "1.0f",
            "1.5d",
            "2d",
            "0x",
            "1e999",
            "1.2.3",
            "1_0",
        ];
        insta::assert_debug_snapshot!(texts.map(|text| format!("{text}: {}", shown(number(text)))));
    }

    #[test]
    fn characters_and_strings() {
        let texts = [
            r"'a'",
            r"'\''",
            r"'\x41'",
            r"'\101b'",
            r"L'\u3042'",
            "L'あ'",
            "'あ'",
            "'é'",
            r"'\xe9'",
            "''",
            "'a",
            r"'\q'",
            r"'\u0041'",
            r"'\400'",
            r"'\é'",
            r"'\'",
        ];
        insta::assert_debug_snapshot!(
            texts.map(|text| format!("{text}: {}", shown(character(text))))
        );
        let texts = [
            r#""a\tb""#,
            r#""\"""#,
            r#"L"あ\u3042""#,
            "\"é\"",
            "\"a\nb\"",
            r#""a\0""#,
            r#""\xé""#,
            r#""\"#,
            "\"",
        ];
        insta::assert_debug_snapshot!(texts.map(|text| format!("{text}: {}", shown(string(text)))));
    }
}
