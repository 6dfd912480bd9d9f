//! In which language a component is written, and for which machines.

use super::{Property, RTC, RTC_EXT, XSI};
use crate::form::profile_form;

profile_form! {
    /// The language of a component.
    pub struct Language {
        /// `rtcExt:language_ext`, when it has elements of `rtcExt`.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// `C++`, `Python`, `Java` and others (since version 0.2).
        kind: attribute = RTC "kind" "kind";
        /// C++ (version 0.1).
        cxx: one<Cxx> = RTC "Cxx" "cxx";
        /// Python (version 0.1).
        python: text = RTC "Python" "python";
        /// Java (version 0.1).
        java: one<Java> = RTC "Java" "java";
        /// C# (version 0.1).
        csharp: text = RTC "Csharp" "csharp";
        /// Ruby (version 0.1).
        ruby: text = RTC "Ruby" "ruby";
        /// The machines it is made for.
        targets: many<TargetEnvironment> = RTC_EXT "targets" "rtcExt::targets|rtcExt::target";
        /// Properties of the language.
        properties: many<Property> = RTC_EXT "Properties" "rtcExt::properties|rtcExt::property";
    }
}

profile_form! {
    /// C++ (version 0.1).
    pub struct Cxx {
        /// Operating system.
        os: attribute = RTC "os" "os";
        /// Architecture.
        arch: attribute = RTC "arch" "arch";
        /// Libraries.
        libraries: texts = RTC "library" "library|libraries";
    }
}

profile_form! {
    /// Java (version 0.1).
    pub struct Java {
        /// Libraries.
        libraries: texts = RTC "library" "library|libraries";
    }
}

profile_form! {
    /// A kind of machine that a component is made for.
    pub struct TargetEnvironment {
        /// Version of the language.
        lang_version: attribute = RTC_EXT "langVersion" "langVersion";
        /// Operating system.
        os: attribute = RTC_EXT "os" "os";
        /// Anything else.
        other: attribute = RTC_EXT "other" "other";
        /// Another processor.
        cpu_other: attribute = RTC_EXT "cpuOther" "cpuOther";
        /// Versions of the operating system.
        os_versions: texts = RTC_EXT "osVersions" "osVersions|osVersion";
        /// Processors.
        cpus: texts = RTC_EXT "cpus" "cpus|cpu";
        /// Libraries.
        libraries: many<Library> = RTC_EXT "libraries" "libraries|library";
    }
}

profile_form! {
    /// A library that a component needs.
    pub struct Library {
        /// Name.
        name: attribute = RTC_EXT "name" "name";
        /// Version.
        version: attribute = RTC_EXT "version" "version";
        /// Anything else.
        other: attribute = RTC_EXT "other" "other";
    }
}
