//! In which language a component is written, and for which machines.

use super::{Property, RTC, RTC_EXT, XSI};
use crate::form::profile_form;

profile_form! {
    /// The language of a component, and the machines it is made for.
    pub struct Language {
        /// Type of the element in the schema: `rtcExt:language_ext`. The schema wants it where the element has
        /// attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// The language: `C++`, `Python`, `Java`, `Lua` and others.
        ///
        /// - Required: by the schema
        /// - Versions: since 0.2
        kind: attribute = RTC "kind" "kind";
        /// The component is written in C++.
        ///
        /// - Versions: only 0.1
        cxx: one<Cxx> = RTC "Cxx" "cxx";
        /// The component is written in Python.
        ///
        /// - Versions: only 0.1
        python: text = RTC "Python" "python";
        /// The component is written in Java.
        ///
        /// - Versions: only 0.1
        java: one<Java> = RTC "Java" "java";
        /// The component is written in C#.
        ///
        /// - Versions: only 0.1
        csharp: text = RTC "Csharp" "csharp";
        /// The component is written in Ruby.
        ///
        /// - Versions: only 0.1
        ruby: text = RTC "Ruby" "ruby";
        /// The machines and systems it is made for.
        ///
        /// - Versions: since 0.2
        targets: many<TargetEnvironment> = RTC_EXT "targets" "rtcExt::targets|rtcExt::target";
        /// Names and values besides, for the language.
        ///
        /// - Versions: since 0.3
        properties: many<Property> = RTC_EXT "Properties" "rtcExt::properties|rtcExt::property";
    }
}

profile_form! {
    /// A component in C++ (version 0.1).
    pub struct Cxx {
        /// Operating system that it is built for.
        os: attribute = RTC "os" "os";
        /// Processor that it is built for: `x86_64`.
        arch: attribute = RTC "arch" "arch";
        /// Names of libraries that it is linked with.
        libraries: texts = RTC "library" "library|libraries";
    }
}

profile_form! {
    /// A component in Java (version 0.1).
    pub struct Java {
        /// Names of libraries that it needs.
        libraries: texts = RTC "library" "library|libraries";
    }
}

profile_form! {
    /// A kind of machine that a component is made for.
    pub struct TargetEnvironment {
        /// Version of the language or its compiler.
        lang_version: attribute = RTC_EXT "langVersion" "langVersion";
        /// Operating system: `Ubuntu`, `Windows`.
        os: attribute = RTC_EXT "os" "os";
        /// Anything else that a machine must have.
        other: attribute = RTC_EXT "other" "other";
        /// A processor that is not in the usual list.
        cpu_other: attribute = RTC_EXT "cpuOther" "cpuOther";
        /// Versions of the operating system, one in each element: `22.04`.
        os_versions: texts = RTC_EXT "osVersions" "osVersions|osVersion";
        /// Processors, one in each element: `x86_64`.
        cpus: texts = RTC_EXT "cpus" "cpus|cpu";
        /// Libraries that must be there, with their versions.
        libraries: many<Library> = RTC_EXT "libraries" "libraries|library";
    }
}

profile_form! {
    /// A library that a component needs.
    pub struct Library {
        /// Name of the library, as it is installed.
        ///
        /// - Required: by the schema
        name: attribute = RTC_EXT "name" "name";
        /// Version of the library that is needed.
        version: attribute = RTC_EXT "version" "version";
        /// Anything else there is to say of the library.
        other: attribute = RTC_EXT "other" "other";
    }
}
