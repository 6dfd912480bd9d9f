//! A component without code: it has the ports of the one whose place it takes, sends numbered samples, reads and counts
//! what comes, and fails when it is told to. Life cycle, execution context, configuration and data ports are those of
//! every other component.

mod marked;
mod reader;
mod typed;

use std::collections::BTreeMap;
use std::thread;
use std::time::{Duration, Instant};

use rts_manager_api::control::StandInShape;
use rts_runtime::abi::callback;

use self::marked::Marked;
use self::reader::Reader;
use crate::component::{Component, PortEnd};
use crate::data::Payload;
use crate::log::Level;

/// The life of one.
pub struct StandIn {
    shape: StandInShape,
    /// By index of the in-port.
    readers: BTreeMap<usize, Reader>,
    /// Number of the last sample of each out-port.
    sequence: u64,
    /// Cycles since its activation: which of its recorded values is next.
    cycle: usize,
    activated: Option<Instant>,
    buffer: Vec<u8>,
}

impl StandIn {
    /// One that was not initialised.
    pub fn new(shape: &StandInShape) -> Self {
        Self {
            shape: shape.clone(),
            readers: BTreeMap::new(),
            sequence: 0,
            cycle: 0,
            activated: None,
            buffer: Vec::new(),
        }
    }

    /// What a module's callback would do. The error is the reason.
    pub fn callback(&mut self, component: &Component, number: u32) -> Result<(), String> {
        match number {
            callback::ON_INITIALIZE => self.initialize(component),
            callback::ON_ACTIVATED => {
                self.activated = Some(Instant::now());
                self.cycle = 0;
                self.fails_in("activate")
            }
            callback::ON_EXECUTE => self.execute(component),
            callback::ON_DEACTIVATED | callback::ON_ABORTING => {
                self.tell(component);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn initialize(&self, component: &Component) -> Result<(), String> {
        let type_name = &component.module.type_name;
        let line = format!("stands in for a {type_name}: none of its code runs");
        component.log.write(Level::Info, &line);
        thread::sleep(Duration::from_millis(self.shape.startup_ms.unwrap_or(0)));
        self.fails_in("initialize")
    }

    fn fails_in(&self, callback: &str) -> Result<(), String> {
        match &self.shape.fail {
            Some(fail) if fail == callback => Err("fails as its stand-in was told to".to_owned()),
            _ => Ok(()),
        }
    }

    fn execute(&mut self, component: &Component) -> Result<(), String> {
        self.crash_in_time(component);
        self.fails_in("execute")?;
        self.sequence += 1;
        for (index, port) in component.ports.iter().enumerate() {
            match port {
                PortEnd::In(port) => {
                    let reader = self.readers.entry(index).or_default();
                    while let Some(payload) = port.read().sample() {
                        if let Err(problem) = reader.take(&port.data_type, &payload) {
                            let line = format!("port {}: {problem}", port.name);
                            component.log.write(Level::Warn, &line);
                        }
                    }
                }
                PortEnd::Out(port) => {
                    let number = self.sequence;
                    let (data_type, buffer) = (&port.data_type, &mut self.buffer);
                    let recorded = self.shape.data.get(&port.name);
                    let recorded = recorded.and_then(|values| next(values, self.cycle));
                    let is_known = match recorded {
                        Some(texts) => typed::encode_recorded(data_type, texts, buffer),
                        None => typed::encode(data_type, number, buffer),
                    };
                    if !is_known {
                        let identity = &component.identity;
                        let (name, life) = (&identity.instance, &identity.incarnation);
                        let sender = format!("{name}.{}#{life}", port.name);
                        Marked::encode_into(&port.data_type, sender, number, &mut self.buffer);
                    }
                    port.write(&Payload::copy_from_slice(&self.buffer));
                }
            }
        }
        self.cycle = self.cycle.wrapping_add(1);
        Ok(())
    }

    /// Brings the whole process down, as a fault in a component's code does.
    fn crash_in_time(&self, component: &Component) {
        let (Some(after), Some(since)) = (self.shape.crash_after_ms, self.activated) else {
            return;
        };
        if since.elapsed() >= Duration::from_millis(after) {
            let line =
                format!("crashes {after} ms after its activation, as its stand-in was told to");
            component.log.write(Level::Error, &line);
            std::process::abort();
        }
    }

    /// Logs what has come.
    fn tell(&self, component: &Component) {
        for (index, reader) in &self.readers {
            if let Some(PortEnd::In(port)) = component.ports.get(*index) {
                let line = format!("port {}: {reader}", port.name);
                component.log.write(Level::Info, &line);
            }
        }
    }
}

/// The value of a cycle: after the last comes the first again.
fn next(values: &[Vec<String>], cycle: usize) -> Option<&[String]> {
    let index = cycle.checked_rem(values.len())?;
    values.get(index).map(Vec::as_slice)
}

#[cfg(test)]
mod tests {
    #[test]
    fn after_the_last_value_comes_the_first_again() {
        let values = ["a", "b", "c"].map(|text| vec![text.to_owned()]);
        let played = (0..7).filter_map(|cycle| super::next(&values, cycle));
        assert_eq!(played.flatten().cloned().collect::<String>(), "abcabca");
        assert_eq!(super::next(&[], 3), None);
    }
}
