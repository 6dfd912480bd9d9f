//! Modules that a C or a C++ compiler made of the header.

#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::path::{Path, PathBuf};
use std::process::Command;

use rts_manager_api::control::*;

use crate::support::*;

/// The sources of this repository.
fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A folder with the header of a later rtsctl, which has appended a field to each struct.
fn later_header(folder: &Path) -> PathBuf {
    let header = "rtsctl/rts_module.h";
    let here = std::fs::read_to_string(repository().join("agent/runtime/include").join(header));
    let structs = [
        "buffer",
        "loan",
        "port",
        "service",
        "parameter",
        "module",
        "host",
    ];
    let later = structs.iter().fold(here.unwrap(), |text, it| {
        let end = format!("}} rts_{it}_t;");
        assert_eq!(text.matches(&end).count(), 1, "{end}");
        text.replace(&end, &format!("  uint64_t appended;\n{end}"))
            .replace(&format!("RTS_STATIC_ASSERT(sizeof(rts_{it}_t)"), "// ")
    });
    let path = folder.join("later").join(header);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(&path, later).unwrap();
    folder.join("later")
}

/// Builds a module of a C source, with the options that choose the language, and a folder of headers that go before ours.
fn build(source: &Path, library: &Path, language: &[&str], headers: Option<&Path>) {
    let ahead = headers.map(|folder| [Path::new("-I"), folder]);
    let done = Command::new("cc")
        .args(language)
        .args(ahead.iter().flatten())
        .args([
            "-Wall",
            "-Wextra",
            "-Wpedantic",
            "-Werror",
            "-shared",
            "-fPIC",
            "-I",
        ])
        .arg(repository().join("agent/runtime/include"))
        .arg("-o")
        .args([library, source])
        .output()
        .expect("a compiler");
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
}

fn load(type_name: &str, path: &Path) -> RequestBody {
    RequestBody::LoadModule {
        type_name: type_name.to_owned(),
        path: path.display().to_string(),
        digest: None,
    }
}

/// A request for a component of a type.
fn create(manager: &Running, type_name: &str, parameters: &[(&str, &str)]) -> CreateRequest {
    match manager.testmod(type_name, parameters) {
        RequestBody::Create(request) => CreateRequest {
            type_name: type_name.to_owned(),
            ..request
        },
        other => panic!("{other:?}"),
    }
}

/// A stand-in for one end of the chain.
fn end(manager: &Running, name: &str, direction: &str, values: &[&str]) -> RequestBody {
    let mut request = create(manager, name, &[]);
    let port = PortInfo {
        name: direction.to_owned(),
        direction: direction.to_owned(),
        data_type: "IDL:RTC/TimedDouble:1.0".to_owned(),
    };
    let values: Vec<_> = values
        .iter()
        .map(|value| vec![(*value).to_owned()])
        .collect();
    request.stand_in = Some(StandInShape {
        ports: vec![port],
        data: (!values.is_empty())
            .then(|| (direction.to_owned(), values))
            .into_iter()
            .collect(),
        ..StandInShape::default()
    });
    request.rate = Some(500.0);
    RequestBody::Create(request)
}

#[test]
fn a_component_in_c_or_cpp_runs_like_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let source = repository().join("manifests/components_c/scale/scale.c");
    let later = later_header(folder.path());
    let (c, cpp) = (["-x", "c", "-std=c11"], ["-x", "c++", "-std=c++11"]);
    // Of today, and of a later rtsctl, whose structs are longer.
    for (language, headers) in [(c, None), (cpp, None), (c, Some(&*later))] {
        let file = format!("lib{}{}.so", language[1], headers.is_some());
        let library = folder.path().join(file);
        build(&source, &library, &language, headers);
        let manager = start("m");
        let mut client = manager.client();
        let ResponseBody::Module(module) = ok(&mut client, load("Scale", &library)) else {
            panic!()
        };
        let factor = &module.facts["factor"];
        assert_eq!(factor.value_type, "double");
        assert_eq!(factor.constraint, "-1000<=x<=1000");

        for (value, why) in [
            ("fast", "it is no `double`"),
            ("5000", "allowed: -1000 <= x <= 1000"),
        ] {
            let request = create(&manager, "Scale", &[("factor", value)]);
            let failure = refused(&mut client, RequestBody::Create(request), SOON);
            assert_eq!(failure.code, FailureCode::Invalid);
            assert_eq!(
                failure.message,
                format!("Scale: parameter `factor` = `{value}` of the set `default`: {why}")
            );
        }

        let request = create(&manager, "Scale", &[("factor", "-4.0")]);
        let made = |answer| match answer {
            ResponseBody::Created { incarnation } => incarnation,
            other => panic!("{other:?}"),
        };
        let scale = made(ok(&mut client, RequestBody::Create(request)));
        let sink = made(ok(&mut client, end(&manager, "Sink", "in", &[])));
        ok(&mut client, end(&manager, "Source", "out", &["1.5"]));
        for (from, to, incarnation) in [("Source", "Scale", scale), ("Scale", "Sink", sink)] {
            let request = connection(from, to, &incarnation, None);
            ok(
                &mut client,
                binding(&request.connector, to, "in", &format!("{from}.out")),
            );
            ok(&mut client, RequestBody::Connect(request));
        }
        for instance in ["Sink", "Scale", "Source"] {
            ok(&mut client, activate(instance));
        }
        until("samples come through", || {
            let sink = component(&mut client, "Sink");
            sink.bindings
                .iter()
                .any(|binding| binding.samples_received >= 3)
        });
        for instance in ["Source", "Scale", "Sink"] {
            ok(&mut client, deactivate(instance));
        }
        let log = manager.log("Scale");
        assert!(log.contains(" samples, the last to -6\n"), "{log}");
        let log = manager.log("Sink");
        assert!(log.contains(" 0 gaps, 0 out of order, 0 faulty"), "{log}");
    }
}

#[test]
fn a_component_in_c_is_connected_over_every_transport() {
    let folder = tempfile::tempdir().unwrap();
    let library = folder.path().join("libscale.so");
    let source = repository().join("manifests/components_c/scale/scale.c");
    build(&source, &library, &["-x", "c", "-std=c11"], None);
    let made = |answer| match answer {
        ResponseBody::Created { incarnation } => incarnation,
        other => panic!("{other:?}"),
    };
    for transport in ["shm", "uds", "tcp"] {
        // Source -> Scale -> Sink, with the one in C alone in its process.
        let (outer, inner) = (start("outer"), start("inner"));
        let (mut o, mut i) = (outer.client(), inner.client());
        ok(&mut i, load("Scale", &library));
        let request = create(&inner, "Scale", &[("factor", "-4.0")]);
        let scale = made(ok(&mut i, RequestBody::Create(request)));
        let sink = made(ok(&mut o, end(&outer, "Sink", "in", &[])));
        ok(&mut o, end(&outer, "Source", "out", &["1.5"]));
        let connect = |from: &str, to: &str, incarnation: &str, socket: &Path| ConnectRequest {
            properties: [("dataport.interface_type".to_owned(), transport.to_owned())].into(),
            ..connection(from, to, incarnation, Some(socket))
        };
        let first = connect("Source", "Scale", &scale, &inner.socket());
        let second = connect("Scale", "Sink", &sink, &outer.socket());
        ok(
            &mut i,
            binding(&first.connector, "Scale", "in", "Source.out"),
        );
        ok(
            &mut o,
            binding(&second.connector, "Sink", "in", "Scale.out"),
        );
        ok(&mut o, RequestBody::Connect(first.clone()));
        ok(&mut i, RequestBody::Connect(second.clone()));
        ok(&mut o, activate("Sink"));
        ok(&mut i, activate("Scale"));
        ok(&mut o, activate("Source"));
        let received = |client: &mut _| component(client, "Sink").bindings[0].samples_received;
        until("samples come through", || received(&mut o) >= 3);
        assert_eq!(
            component(&mut o, "Source").connectors[0].transport,
            transport
        );
        assert_eq!(
            component(&mut i, "Scale").connectors[0].transport,
            transport
        );

        // An order is a good-bye, and connected again it goes on.
        ok(&mut i, disconnect("Scale", &second.connector));
        until("the end is seen", || {
            !component(&mut o, "Sink").bindings[0].connected
        });
        ok(&mut i, RequestBody::Connect(second));
        until("samples come through again", || received(&mut o) >= 3);
        ok(&mut o, deactivate("Sink"));
        let log = outer.log("Sink");
        assert!(log.contains(" 0 out of order, 0 faulty"), "{log}");

        ok(&mut o, on_disconnect("Source", "deactivate"));
        inner.signal("-KILL");
        until("its death is noticed at both ends", || {
            component(&mut o, "Source").state == "Inactive"
                && !component(&mut o, "Sink").bindings[0].connected
        });
    }
}

#[test]
fn a_module_of_another_version_is_refused_with_both_versions_and_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let manager = start("m");
    let mut client = manager.client();
    for (version, advice) in [
        (0, "rebuild the module with the SDK of this rtsctl"),
        (
            2,
            "upgrade rtsctl on this node, or rebuild the module with the SDK of this rtsctl",
        ),
    ] {
        let source = folder.path().join("it.c");
        let text = format!("const void *rts_module_v{version}(void) {{ return 0; }}\n");
        std::fs::write(&source, text).unwrap();
        let library = folder.path().join(format!("lib{version}.so"));
        build(&source, &library, &["-Wno-missing-prototypes"], None);
        let failure = refused(&mut client, load("It", &library), SOON);
        assert_eq!(failure.code, FailureCode::LoadFailed);
        assert_eq!(
            failure.message,
            format!(
                "type It: {} was built for version {version} of the module interface, and this manager speaks version \
                 1; {advice}",
                library.display()
            )
        );
    }
}
