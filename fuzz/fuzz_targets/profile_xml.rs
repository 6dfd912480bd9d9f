//! Any text in the root elements of RTS and RTC Profiles in XML: most bytes reach no reader without them.
#![no_main]

#[path = "../laws.rs"]
mod laws;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let whole = |root: &str, kind: &str| {
        let namespace = format!("http://www.openrtp.org/namespaces/{kind}");
        format!(
            "<{kind}:{root} xmlns:{kind}='{namespace}' xmlns:{kind}Ext='{namespace}_ext' xmlns:{kind}Doc='{namespace}_doc' \
             xmlns:xsi='http://www.w3.org/2001/XMLSchema-instance'>{text}</{kind}:{root}>"
        )
    };
    laws::system(whole("RtsProfile", "rts").as_bytes());
    laws::component(whole("RtcProfile", "rtc").as_bytes());
});
