//! Names of properties.

/// Names that are read, with `PORT` for `outport` and `inport`.
const NAMES: [&str; 14] = [
    "dataport.interface_type",
    "dataport.dataflow_type",
    "dataport.subscription_type",
    "dataport.serializer.cdr.endian",
    "dataport.push_rate",
    "dataport.push_interval",
    "dataport.publisher.push_policy",
    "dataport.publisher.push_rate",
    "dataport.publisher.skip_count",
    "dataport.buffer.length",
    "dataport.buffer.write.full_policy",
    "dataport.buffer.write.timeout",
    "dataport.buffer.read.empty_policy",
    "dataport.buffer.read.timeout",
];

/// Letters that may be wrong in a slip of the pen.
const SLIPS: usize = 2;

/// The name that was meant, when this one is not known and all but one that is.
pub fn meant(name: &str) -> Option<String> {
    let name = name.to_ascii_lowercase();
    let ends = ["outport", "inport"];
    let of_end = |end: &&str| name.starts_with(&format!("dataport.{end}."));
    let end = ends.into_iter().find(of_end);
    let own = NAMES.iter().map(|known| match end {
        Some(end) => known.replacen("dataport.", &format!("dataport.{end}."), 1),
        None => (*known).to_owned(),
    });
    let length = name.chars().count();
    // The distance takes time that is quadratic, and is at least the difference of the lengths. Most names are right.
    let near = own.filter(|known| known.len().abs_diff(length) <= SLIPS);
    let near: Vec<String> = near.collect();
    if near.contains(&name) {
        return None;
    }
    let far = |known: &String| strsim::damerau_levenshtein(known, &name);
    let distances = near.into_iter().map(|known| (far(&known), known));
    let (distance, known) = distances.min_by_key(|(distance, _)| *distance)?;
    (distance <= SLIPS).then_some(known)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_told_from_names_of_others() {
        for (name, other) in [
            ("dataport.buffer.lenght", "dataport.buffer.length"),
            (
                "dataport.outport.bufer.length",
                "dataport.outport.buffer.length",
            ),
            (
                "dataport.inport.buffer.read.emptypolicy",
                "dataport.inport.buffer.read.empty_policy",
            ),
            ("dataport.subscribtion_type", "dataport.subscription_type"),
            ("dataport.buffer.lengthab", "dataport.buffer.length"),
        ] {
            assert_eq!(meant(name).as_deref(), Some(other), "{name}");
        }
        for name in [
            "dataport.buffer.length",
            "dataport.inport.buffer.length",
            "dataport.data_type",
            "dataport.corba_cdr.inport_ior",
            "dataport.outport.publisher.push_policy",
            "color",
            "",
            // Two letters too many are slips, three are not.
            "dataport.buffer.lengthabc",
        ] {
            assert_eq!(meant(name), None, "{name}");
        }
    }
}
