//! A system as a user wishes it, and how wishes change.

mod change;

use std::collections::BTreeSet;
use std::fmt::Write;

use super::draw::Draw;
use crate::Profile;

pub use change::{rewired, touched};

/// Calls per second of every component: 64 samples, what a queue holds, are two and a half seconds.
const RATE: &str = "25.0";
/// Managers of a system.
const MANAGERS: [&str; 3] = ["a", "b", "c"];
/// Most components of a system.
const MOST: usize = 8;

/// What a component is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// `SineSource`.
    Sine,
    /// `SeqOut`, of which one port is used.
    SeqOut,
    /// `LowPassFilter`.
    Filter,
    /// `Printer`.
    Printer,
    /// `SeqIn`, of which one port is used.
    SeqIn,
}

impl Kind {
    fn type_name(self) -> &'static str {
        match self {
            Self::Sine => "SineSource",
            Self::SeqOut => "SeqOut",
            Self::Filter => "LowPassFilter",
            Self::Printer => "Printer",
            Self::SeqIn => "SeqIn",
        }
    }

    fn output(self) -> Option<&'static str> {
        match self {
            Self::Sine | Self::Filter => Some("out"),
            Self::SeqOut => Some("Double"),
            Self::Printer | Self::SeqIn => None,
        }
    }

    fn input(self) -> Option<&'static str> {
        match self {
            Self::Filter | Self::Printer => Some("in"),
            Self::SeqIn => Some("Double"),
            Self::Sine | Self::SeqOut => None,
        }
    }
}

/// One component.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// Instance name.
    pub instance: String,
    /// What it is.
    pub kind: Kind,
    /// Name of its manager.
    pub manager: String,
    /// Instance that its samples come from; none for a source.
    pub from: Option<String>,
    /// Its parameter, where it has one that is changed.
    pub value: u64,
    /// Its process is replaced when it hangs.
    pub watched: bool,
}

/// A system.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wish {
    /// Its name.
    pub name: String,
    /// Rises with each wish for it; the first part's parameter shows it.
    pub serial: u64,
    /// Sources before what they feed. The second is a printer with the serial.
    pub parts: Vec<Part>,
    /// Activated from the last to the first, each when the one before it is Active.
    pub ordered: bool,
    numbered: u64,
}

/// How a wish changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// Not at all.
    Nothing,
    /// A parameter.
    Configuration,
    /// Where samples come from.
    Connector,
    /// The manager of a component.
    Manager,
    /// One component more.
    More,
    /// One component less.
    Less,
}

impl Wish {
    /// A new system.
    pub fn draw(name: &str, draw: &mut Draw) -> Self {
        let mut wish = Self {
            name: name.to_owned(),
            serial: 1,
            parts: Vec::new(),
            ordered: draw.percent(50),
            numbered: 0,
        };
        let source = *draw
            .pick(&[Kind::Sine, Kind::SeqOut])
            .unwrap_or(&Kind::Sine);
        wish.add(source, draw);
        wish.add(Kind::Printer, draw);
        for _ in 0..draw.between(1, 4) {
            wish.add_any(draw);
        }
        wish.mark();
        wish
    }

    /// The next wish for this system.
    #[must_use]
    pub fn changed(&self, change: Change, draw: &mut Draw) -> Self {
        let mut wish = self.clone();
        if change == Change::Nothing {
            return wish;
        }
        wish.serial += 1;
        wish.mark();
        match change {
            Change::Nothing => {}
            Change::Configuration => wish.configure(draw),
            Change::Connector => wish.rewire(draw),
            Change::Manager => wish.move_one(draw),
            Change::More => wish.add_any(draw),
            Change::Less => wish.remove(draw),
        }
        wish
    }

    /// The printer shows the serial.
    fn mark(&mut self) {
        self.parts[1].value = self.serial;
    }

    fn add_any(&mut self, draw: &mut Draw) {
        if self.parts.len() < MOST {
            let kinds = [
                (2, Kind::Filter),
                (2, Kind::Printer),
                (1, Kind::SeqIn),
                (1, Kind::Sine),
            ];
            let kind = draw.weighted(&kinds);
            self.add(kind, draw);
        }
    }

    fn add(&mut self, kind: Kind, draw: &mut Draw) {
        let from = kind
            .input()
            .and_then(|_| self.source_before(self.parts.len(), draw));
        self.parts.push(Part {
            instance: format!("{}p{}", self.name, self.numbered),
            kind,
            manager: draw_manager(draw),
            from,
            value: 1,
            watched: draw.percent(30),
        });
        self.numbered += 1;
    }

    /// An instance with an out-port before this place.
    fn source_before(&self, place: usize, draw: &mut Draw) -> Option<String> {
        let sources = self.parts[..place].iter();
        let sources: Vec<_> = sources.filter(|p| p.kind.output().is_some()).collect();
        draw.pick(&sources).map(|part| part.instance.clone())
    }

    fn configure(&mut self, draw: &mut Draw) {
        let serial = self.serial;
        let filters = self.parts.iter_mut().filter(|p| p.kind == Kind::Filter);
        for filter in filters {
            if draw.percent(50) {
                filter.value = serial;
            }
        }
    }

    fn rewire(&mut self, draw: &mut Draw) {
        let place = draw.between(1, self.parts.len() as u64 - 1) as usize;
        if self.parts[place].from.is_some() {
            self.parts[place].from = self.source_before(place, draw);
        }
    }

    fn move_one(&mut self, draw: &mut Draw) {
        let place = draw.between(0, self.parts.len() as u64 - 1) as usize;
        self.parts[place].manager = draw_manager(draw);
    }

    /// Never one of the first two. What it fed is fed by the first.
    fn remove(&mut self, draw: &mut Draw) {
        if self.parts.len() < 3 {
            return;
        }
        let place = draw.between(2, self.parts.len() as u64 - 1) as usize;
        let gone = self.parts.remove(place).instance;
        let first = self.parts[0].instance.clone();
        for part in &mut self.parts {
            if part.from.as_ref() == Some(&gone) {
                part.from = Some(first.clone());
            }
        }
    }

    /// The component of this name.
    pub fn part(&self, instance: &str) -> Option<&Part> {
        self.parts.iter().find(|part| part.instance == instance)
    }

    /// Names of the managers, sorted.
    pub fn managers(&self) -> BTreeSet<&str> {
        self.parts
            .iter()
            .map(|part| part.manager.as_str())
            .collect()
    }

    /// Pairs of (first, then) in the order of activation.
    pub fn order(&self) -> Vec<(&str, &str)> {
        let mut pairs = Vec::new();
        if self.ordered {
            let names: Vec<_> = self
                .parts
                .iter()
                .rev()
                .map(|p| p.instance.as_str())
                .collect();
            pairs.extend(names.windows(2).map(|pair| (pair[0], pair[1])));
        }
        pairs
    }

    /// `(name, source, target)` of the connectors; the ends are `Instance.port`.
    pub fn connectors(&self) -> Vec<(String, String, String)> {
        let one = |part: &Part| {
            let from = self.part(part.from.as_deref()?)?;
            let source = format!("{}.{}", from.instance, from.kind.output()?);
            let target = format!("{}.{}", part.instance, part.kind.input()?);
            Some((format!("{source}-{target}"), source, target))
        };
        self.parts.iter().filter_map(one).collect()
    }

    /// The profile.
    pub fn xml(&self) -> String {
        let mut profile = Profile::new(&self.name);
        for part in &self.parts {
            profile = profile
                .component(&part.instance, part.kind.type_name())
                .with("manager", &part.manager);
            if let Some((name, value)) = part.parameter() {
                profile = profile.parameter(name, &value);
            }
            if part.watched {
                profile = profile
                    .with("livenessTimeout", "1s")
                    .with("onHang", "restart");
            }
        }
        for (_, source, target) in self.connectors() {
            profile = profile.connect(&source, &target);
        }
        let context = format!(
            r#"</rts:ConfigurationSets><rts:ExecutionContexts xsi:type="rtsExt:execution_context_ext" rts:id="0" rts:kind="PERIODIC" rts:rate="{RATE}"/>"#
        );
        let end = format!("{}</rts:RtsProfile>", self.orders());
        let xml = profile.xml().replace("</rts:ConfigurationSets>", &context);
        xml.replace("</rts:RtsProfile>", &end)
    }

    fn orders(&self) -> String {
        let pairs = self.order();
        let end = |tag: &str, instance: &str| {
            format!(r#"<rts:{tag} rts:id="0" rts:instanceName="{instance}" rts:componentId=""/>"#)
        };
        let mut text = String::new();
        for (nr, (first, then)) in pairs.iter().enumerate() {
            let _ = write!(
                text,
                r#"<rts:targets rts:sequence="{}"><rts:Preceding rts:sendingTiming="SYNC" rts:timeout="0">{}</rts:Preceding>{}</rts:targets>"#,
                nr + 1,
                end("PrecedingComponents", first),
                end("TargetComponent", then),
            );
        }
        match text.is_empty() {
            true => text,
            false => format!("<rts:Activation>{text}</rts:Activation>\n"),
        }
    }
}

impl Part {
    /// Name and value of the parameter that shows [`Part::value`].
    pub fn parameter(&self) -> Option<(&'static str, String)> {
        match self.kind {
            Kind::Filter => Some(("gain", format!("{}.0", self.value))),
            Kind::Printer => Some(("prefix", format!("v{}=", self.value))),
            Kind::Sine | Kind::SeqOut | Kind::SeqIn => None,
        }
    }

    /// The same component: it may change in place.
    fn is_same(&self, other: &Self) -> bool {
        self.kind == other.kind && self.manager == other.manager
    }
}

fn draw_manager(draw: &mut Draw) -> String {
    draw.pick(&MANAGERS).copied().unwrap_or("a").to_owned()
}

#[cfg(test)]
mod tests;
