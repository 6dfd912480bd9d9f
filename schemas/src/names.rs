//! Names: of systems, types, managers and module files, and what makes one valid.

/// Longest instance or type name, in bytes. They become file names (255) with a suffix.
pub const NAME_LIMIT: usize = 128;

/// Longest DNS label (RFC 1035), in characters.
const LABEL_LIMIT: usize = 63;

/// The name of a system from its id, as a DNS label.
///
/// With four or more colon fields it is the third. Otherwise `RTSystem:`, a version after the last colon and trailing
/// `.digits` go, and the last dot field stays. `RTSystem` and `DefaultSystem…`, which editors write when nobody chose
/// a name, give way to the stem of the file. `None` when nothing usable is left.
pub fn system_name(id: &str, file_stem: Option<&str>) -> Option<String> {
    let name = id_name(id.trim());
    let placeholder = name.is_empty() || name == "RTSystem" || name.starts_with("DefaultSystem");
    if placeholder {
        file_stem.and_then(dns_label)
    } else {
        dns_label(name)
    }
}

fn id_name(id: &str) -> &str {
    let fields: Vec<&str> = id.split(':').collect();
    if fields.len() >= 4 {
        return fields[2].trim();
    }
    let mut rest = id;
    if let Some((head, tail)) = id.split_once(':')
        && head.trim() == "RTSystem"
    {
        rest = tail;
    }
    if let Some((head, tail)) = rest.rsplit_once(':')
        && is_version(tail)
    {
        rest = head;
    }
    while let Some((head, tail)) = rest.rsplit_once('.')
        && is_number(tail)
    {
        rest = head;
    }
    rest.rsplit('.').next().unwrap_or(rest).trim()
}

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit())
}

fn is_version(text: &str) -> bool {
    text.trim().split('.').all(is_number)
}

/// The type of a component from its id, as far as the id says one.
///
/// Field 4 of `RTC:vendor:category:type:version`; the last dot field of the second in `RTC:vendor.category.type:version`.
/// Choreonoid writes the instance name in that place: then the trailing number goes.
pub fn type_name(id: &str, instance: &str) -> Option<String> {
    let fields: Vec<&str> = id.split(':').map(str::trim).collect();
    let name = match fields.as_slice() {
        [_, _, _, name, _, ..] => name,
        [_, _, name, _] => name,
        [_, dotted, _] | [_, dotted] => dotted.rsplit('.').next()?,
        _ => return None,
    };
    let stripped = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let name = if name == instance && !stripped.is_empty() {
        stripped
    } else {
        name
    };
    (!name.is_empty()).then(|| name.to_owned())
}

/// `RTC:vendor.category.type:version` (version 0.1) as `RTC:vendor:category:type:version`, and `RTSystem:vendor.name:version`
/// as `RTSystem:vendor:name:version`; any other id as it is. Only the vendor may have dots of its own.
pub fn id_with_colons(id: &str) -> String {
    let fields: Vec<&str> = id.split(':').collect();
    let [head, dotted, version] = fields.as_slice() else {
        return id.to_owned();
    };
    let count = if head.trim() == "RTSystem" { 2 } else { 3 };
    let mut parts: Vec<&str> = dotted.rsplitn(count, '.').collect();
    if parts.len() < count {
        return id.to_owned();
    }
    parts.reverse();
    format!("{head}:{}:{version}", parts.join(":"))
}

/// The other way round; `None` when the id cannot be said with dots.
pub fn id_with_dots(id: &str) -> Option<String> {
    let fields: Vec<&str> = id.split(':').collect();
    let (head, version) = (fields.first()?, fields.last()?);
    let dotted = match fields.len() {
        0..=3 => return Some(id.to_owned()),
        4 | 5 => fields[1..fields.len() - 1].join("."),
        _ => return None,
    };
    let dotted = format!("{head}:{dotted}:{version}");
    (id_with_colons(&dotted) == id).then_some(dotted)
}

/// Any text as a DNS label: lower case, other characters as single hyphens, at most 63.
pub fn dns_label(text: &str) -> Option<String> {
    let mut label = String::new();
    for c in text.trim().chars() {
        if c.is_ascii_alphanumeric() {
            label.push(c.to_ascii_lowercase());
        } else if !label.is_empty() && !label.ends_with('-') {
            label.push('-');
        }
        if label.len() == LABEL_LIMIT {
            break;
        }
    }
    let label = label.trim_end_matches('-');
    (!label.is_empty()).then(|| label.to_owned())
}

/// True for a DNS label: 1 to 63 of `a-z0-9-`, no hyphen at either end.
pub fn is_dns_label(text: &str) -> bool {
    (1..=LABEL_LIMIT).contains(&text.len())
        && text
            .bytes()
            .all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-')
        && !text.starts_with('-')
        && !text.ends_with('-')
}

/// The stem of a profile's file name, without folder and the endings of profiles; `None` for `-` and `<stdin>`.
pub fn file_stem(file_name: &str) -> Option<&str> {
    if matches!(file_name, "-" | "<stdin>") {
        return None;
    }
    let base = file_name.rsplit(['/', '\\']).next()?;
    let stem = match base.rsplit_once('.') {
        Some((stem, _)) if !stem.is_empty() => stem,
        _ => base,
    };
    let stem = stem
        .strip_suffix(".rtsys")
        .or_else(|| stem.strip_suffix(".rts"))
        .unwrap_or(stem);
    (!stem.is_empty()).then_some(stem)
}

/// Why a text cannot be an instance name; `None` when it can. The name may have blanks inside, `%` and any script, so
/// who makes a file name of it must escape.
pub fn instance_name_problem(text: &str) -> Option<String> {
    if let Some(fault) = name_fault(text) {
        return Some(fault.to_owned());
    }
    if text.starts_with('.') {
        Some("it starts with a dot".to_owned())
    } else if text.trim() != text {
        Some("it has blanks at an end".to_owned())
    } else {
        None
    }
}

/// Why a text cannot name a manager; `None` when it can.
pub fn manager_name_problem(text: &str) -> Option<String> {
    let rule = "a manager's name has 1 to 63 letters, digits, `-`, `_` and `.`, the first a letter or digit";
    (!is_manager_name(text)).then(|| rule.to_owned())
}

/// True for a usable manager name: 1 to 63 of letters, digits, `-`, `_` and `.`, starting with a letter or digit.
pub fn is_manager_name(text: &str) -> bool {
    (1..=LABEL_LIMIT).contains(&text.len())
        && text.starts_with(|c: char| c.is_ascii_alphanumeric())
        && text
            .bytes()
            .all(|b| b.is_ascii_alphanumeric() || matches!(b, b'-' | b'_' | b'.'))
}

/// The nearest usable manager name; also good as a file name. `None` when nothing usable is left.
pub fn manager_name(text: &str) -> Option<String> {
    let name: String = text
        .trim()
        .chars()
        .map(|c| {
            if c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.') {
                c
            } else {
                '-'
            }
        })
        .skip_while(|c| !c.is_ascii_alphanumeric())
        .take(LABEL_LIMIT)
        .collect();
    let name = name.trim_end_matches('-');
    (!name.is_empty()).then(|| name.to_owned())
}

/// True for what a terminal obeys instead of showing it: control characters, and those that turn the direction of writing.
pub fn is_hidden(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Why a text cannot be an instance, type or port name; `None` when it can.
pub fn name_fault(text: &str) -> Option<&'static str> {
    if text.trim().is_empty() {
        Some("it is empty")
    } else if text.len() > NAME_LIMIT {
        Some("it is longer than 128 bytes")
    } else if text.chars().any(is_hidden) {
        Some("it has a control character")
    } else if text.contains('/') {
        Some("it has a `/`")
    } else if text == "." || text == ".." {
        Some("it names a folder")
    } else {
        None
    }
}

/// Why a text cannot name a connector; `None` when it can. The name is mostly made of those of its ends, so that it has
/// no length of its own.
pub fn connector_name_fault(text: &str) -> Option<&'static str> {
    if text.trim().is_empty() {
        Some("it is empty")
    } else if text.chars().any(is_hidden) {
        Some("it has a control character")
    } else if text.contains('/') {
        Some("it has a `/`")
    } else {
        None
    }
}

/// The file names under which the module of a type is looked for, in this order.
pub fn module_file_names(type_name: &str) -> [String; 2] {
    [
        format!("lib{}.so", snake_case(type_name)),
        format!("{type_name}.so"),
    ]
}

/// `LowPassFilter` → `low_pass_filter`, `MyRTCImpl` → `my_rtc_impl`: as Cargo would name the library.
fn snake_case(text: &str) -> String {
    let chars: Vec<char> = text.chars().collect();
    let mut snake = String::new();
    for (i, c) in chars.iter().enumerate() {
        let before = i.checked_sub(1).map(|i| chars[i]);
        let after = chars.get(i + 1);
        let word_starts = c.is_uppercase()
            && before.is_some_and(|b| {
                b.is_lowercase()
                    || b.is_ascii_digit()
                    || (b.is_uppercase() && after.is_some_and(|a| a.is_lowercase()))
            });
        if word_starts {
            snake.push('_');
        }
        if c.is_alphanumeric() {
            snake.extend(c.to_lowercase());
        } else {
            snake.push('_');
        }
    }
    snake
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn system_names() {
        let name = |id| system_name(id, Some("file"));
        assert_eq!(name("RTSystem:AIST:hello:1.0").unwrap(), "hello");
        assert_eq!(name("RTSystem:ta.ta-sample:1.0").unwrap(), "ta-sample");
        assert_eq!(
            name("RTSystem:jp.go.aist:SampleRTS:1.0.0").unwrap(),
            "samplerts"
        );
        assert_eq!(name("RTSystem :Me.Robot.0").unwrap(), "robot");
        assert_eq!(name("RTSystem :Me.RTSystem.0").unwrap(), "file");
        assert_eq!(
            name("RTSystem :Sugar Sweet Robotics.DefaultSystem01.1.0").unwrap(),
            "file"
        );
        assert_eq!(name("RTSystem:1:3:2").unwrap(), "3");
        assert_eq!(name("").unwrap(), "file");
        assert_eq!(system_name("RTSystem:v:日本:1.0", None), None);
        // Somebody chose that name: another must not be guessed.
        assert_eq!(name("RTSystem:v:日本:1.0"), None);
    }

    #[test]
    fn types() {
        let of = |id| type_name(id, "ConsoleIn0");
        assert_eq!(of("RTC:AIST:example:ConsoleIn:1.0").unwrap(), "ConsoleIn");
        assert_eq!(
            of("RTC:Noriaki Ando, AIST.example.ConsoleIn:1.0").unwrap(),
            "ConsoleIn"
        );
        assert_eq!(of("RTC:AIST:example:ConsoleIn0:1.0").unwrap(), "ConsoleIn");
        assert_eq!(of("RTC:AIST:example:Sensor2:1.0").unwrap(), "Sensor2");
        assert_eq!(of("RTC"), None);
        assert_eq!(of(""), None);
        assert_eq!(of("RTC:a:b::1"), None);
    }

    #[test]
    fn module_files() {
        let of = |name| module_file_names(name)[0].clone();
        assert_eq!(of("ConsoleIn"), "libconsole_in.so");
        assert_eq!(of("SeqIn"), "libseq_in.so");
        assert_eq!(of("LowPassFilter"), "liblow_pass_filter.so");
        assert_eq!(of("MyRTCImpl"), "libmy_rtc_impl.so");
        assert_eq!(of("Motor2D"), "libmotor2_d.so");
        assert_eq!(of("Turtlebot-KobukiIoRTC"), "libturtlebot_kobuki_io_rtc.so");
        assert_eq!(module_file_names("ConsoleIn")[1], "ConsoleIn.so");
    }

    #[test]
    fn stems_and_labels() {
        assert_eq!(file_stem("/a/b/plan_all.rtsys.xml"), Some("plan_all"));
        assert_eq!(
            file_stem("DefaultSystem.xml20231114222805"),
            Some("DefaultSystem")
        );
        assert_eq!((file_stem("-"), file_stem("<stdin>")), (None, None));
        assert_eq!(
            dns_label("root-RTSystem~125fbf1").unwrap(),
            "root-rtsystem-125fbf1"
        );
        assert_eq!(dns_label(" - "), None);
        assert!(is_dns_label(&dns_label(&"x-".repeat(100)).unwrap()));
        assert!(!is_dns_label("Hello"));
        assert_eq!(manager_name("ロボット left arm").unwrap(), "left-arm");
        assert!(is_manager_name("m1") && !is_manager_name("../x"));
        assert_eq!(name_fault("a/b"), Some("it has a `/`"));
        assert_eq!(name_fault("Sine 0"), None);
        let long = format!("{}.out-{}.in", "x".repeat(128), "y".repeat(128));
        assert_eq!(connector_name_fault(&long), None);
        assert_eq!(connector_name_fault("a/b"), Some("it has a `/`"));
    }

    #[test]
    fn ids_with_dots_and_colons() {
        for (dots, colons) in [
            (
                "RTC:Noriaki Ando, AIST.example.ConsoleIn:1.0",
                "RTC:Noriaki Ando, AIST:example:ConsoleIn:1.0",
            ),
            ("RTC:Meijo Univ..a.B:1.0", "RTC:Meijo Univ.:a:B:1.0"),
            ("RTSystem:ta.ta-sample:1.0", "RTSystem:ta:ta-sample:1.0"),
        ] {
            assert_eq!(id_with_colons(dots), colons);
            assert_eq!(id_with_dots(colons).as_deref(), Some(dots));
        }
        for other in ["", "x", "RTC:a.b:1.0", "RTC:a"] {
            assert_eq!(id_with_colons(other), other);
        }
        assert_eq!(id_with_dots("RTC:v:a.b:C:1.0"), None);
        assert_eq!(id_with_dots("RTC:v:a:b:c:d:1.0"), None);
    }

    #[test]
    fn instance_names_are_fit_for_files() {
        for good in ["Sine0", "My Sine", "左腕0", "50%", "a.b", &"x".repeat(128)] {
            assert_eq!(instance_name_problem(good), None, "{good}");
        }
        for bad in [
            "",
            " ",
            ".",
            "..",
            ".x",
            " x",
            "x ",
            "a/b",
            "a\nb",
            &"x".repeat(129),
        ] {
            assert!(instance_name_problem(bad).is_some(), "{bad:?}");
        }
        assert_eq!(manager_name_problem("arm-1.left"), None);
        assert!(manager_name_problem("-arm").is_some());
    }
}
