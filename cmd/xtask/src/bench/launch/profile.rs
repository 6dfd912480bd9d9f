//! A profile of components without ports, to measure with.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use super::TYPE;

/// A system of equal components.
pub struct Profile {
    system: &'static str,
    components: u32,
    isolated: bool,
    host: &'static str,
}

impl Profile {
    /// Components that share a process, or have one each.
    pub fn new(system: &'static str, components: u32, isolated: bool) -> Self {
        Self {
            system,
            components,
            isolated,
            host: "localhost",
        }
    }

    /// The same on another host.
    #[must_use]
    pub fn on(self, host: &'static str) -> Self {
        Self { host, ..self }
    }

    /// Writes it into a folder, named after the system.
    pub fn write(&self, folder: &Path) -> Result<PathBuf> {
        self.write_as(self.system, folder)
    }

    /// The same with another file name.
    pub fn write_as(&self, name: &str, folder: &Path) -> Result<PathBuf> {
        let file = folder.join(format!("{name}.xml"));
        std::fs::write(&file, self.text())
            .with_context(|| format!("cannot write {}", file.display()))?;
        Ok(file)
    }

    fn text(&self) -> String {
        let Self {
            system,
            isolated,
            host,
            ..
        } = self;
        let components: String = (0..self.components)
            .map(|i| {
                format!(
                    r#"<rts:Components rts:id="RTC:rtsctl:bench:{TYPE}:1.0" rts:instanceName="{system}{i}" rts:pathUri="{host}/{system}{i}.rtc" rts:compositeType="None" rts:isRequired="true">
<rts:ExecutionContexts rts:id="0" rts:kind="PERIODIC" rts:rate="10.0"/>
<rtsExt:Properties rtsExt:name="rtsctl.isolated" rtsExt:value="{isolated}"/>
</rts:Components>
"#
                )
            })
            .collect();
        format!(
            r#"<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:rtsctl:{system}:1.0" rts:version="0.2" rts:creationDate="2026-01-01T00:00:00" rts:updateDate="2026-01-01T00:00:00" xmlns:rts="http://www.openrtp.org/namespaces/rts" xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext">
{components}</rts:RtsProfile>
"#
        )
    }
}
