use super::*;

fn error(text: &str) -> (String, String) {
    let error = parse(text).unwrap_err();
    let place = Source::new("t.xml", text).place(error.span.start, error.span.end);
    (
        format!("{}:{} {}", place.line, place.column, error.code),
        error.message,
    )
}

#[test]
fn tree_has_namespaces_places_and_comments() {
    let text = "<?xml version=\"1.0\"?>\n<a:r xmlns:a='urn:a' a:k=\"v &amp; w\"><!--c--><b>x&#65;&lt;</b></a:r>\n";
    let root = parse(text).unwrap();
    assert_eq!((&*root.namespace, root.local()), ("urn:a", "r"));
    let k = root.attribute(&["urn:a"], "k").unwrap();
    assert_eq!(k.value, "v & w");
    assert_eq!(&text[k.span.range()], "v &amp; w");
    assert_eq!(root.children[0], Node::Comment("c".into()));
    let b = root.elements().next().unwrap();
    assert_eq!(b.children, [Node::Text("xA<".into())]);
    assert_eq!(&*b.namespace, "");
}

#[test]
fn what_is_not_well_formed_has_a_place() {
    assert_eq!(error("<a>\n<b></c></a>").0, "2:4 malformed-xml");
    assert_eq!(error("<a>\n <b>").0, "2:2 malformed-xml");
    assert_eq!(error("<a k='1' k='2'/>").0, "1:1 malformed-xml");
    assert_eq!(error("<a/><b/>").0, "1:5 malformed-xml");
    assert_eq!(error("<a/>x").0, "1:5 malformed-xml");
    assert_eq!(error("<a k='&nope;'/>").0, "1:7 malformed-xml");
    assert_eq!(error("<a>&nope;</a>").0, "1:4 malformed-xml");
    assert_eq!(error("<p:a/>").1, "the prefix `p:` is not declared");
    assert_eq!(error("").1, "there is no element");
}

#[test]
fn dtd_and_depth_are_refused() {
    let bomb = "<!DOCTYPE a [<!ENTITY x \"y\">]><a>&x;</a>";
    assert_eq!(parse(bomb).unwrap_err().code, "dtd-refused");
    let deep = "<a>".repeat(DEPTH_LIMIT + 1);
    assert_eq!(parse(&deep).unwrap_err().code, "too-deep");
    let ok = "<a>".repeat(DEPTH_LIMIT) + &"</a>".repeat(DEPTH_LIMIT);
    assert!(parse(&ok).is_ok());
}

#[test]
fn encodings() {
    let cp932 = encoding_rs::SHIFT_JIS
        .encode("<a k='日本語①'/>")
        .0
        .into_owned();
    let as_declared = |label: &str| {
        let mut bytes = format!("<?xml version='1.0' encoding='{label}'?>").into_bytes();
        bytes.extend(&cp932);
        decode("t.xml", &bytes)
    };
    let decoded = as_declared("Windows-31J").unwrap();
    assert!(decoded.text.contains("日本語①") && decoded.warning.is_none());
    let decoded = as_declared("UTF-8").unwrap();
    assert!(decoded.text.contains("日本語①"));
    assert_eq!(decoded.warning.unwrap().code, "encoding-mismatch");
    let decoded = as_declared("x-klingon").unwrap();
    assert_eq!(decoded.warning.unwrap().code, "encoding-mismatch");
    let utf16: Vec<u8> = "\u{feff}<a/>"
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    assert_eq!(decode("t.xml", &utf16).unwrap().text, "<a/>");
    assert_eq!(
        decode("t.xml", b"<a>\xff\xff</a>").unwrap_err().code,
        "bad-encoding"
    );
}

#[test]
fn the_name_of_a_namespace_is_unescaped() {
    let root = parse("<a:r xmlns:a='x&lt;&#10;y\nz' a:k=''/>").unwrap();
    assert_eq!(&*root.namespace, "x<\ny z");
    assert_eq!(&*root.attributes[0].value, &*root.namespace);
    assert!(root.attribute(&["x<\ny z"], "k").is_some());
}

#[test]
fn too_many_declarations_are_refused() {
    let some =
        |count: usize| -> String { (0..count).map(|n| format!(" xmlns:p{n}='u'")).collect() };
    let text = |count| format!("<a{0}><a{0}/><a{0}/></a>", some(count));
    assert!(parse(&text(64)).is_ok());
    // Each name is looked for in all declarations that are in force, so that quick-xml allows 128.
    let error = parse(&text(65)).unwrap_err();
    assert!(error.message.contains("128"), "{}", error.message);
}
