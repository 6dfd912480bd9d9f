//! A system as a picture (SVG): nodes as frames, components in the colours of their states, ports and connectors.

mod layout;
mod model;
mod svg;

use rts_controller_api::objects::{Component, Connector};
use rts_schemas::system::SystemSpec;

/// The picture. What is not among the components and connectors is drawn as Unknown.
pub fn svg(spec: &SystemSpec, components: &[Component], connectors: &[Connector]) -> String {
    let model = model::of(spec, components, connectors);
    svg::render(&model, &layout::of(&model))
}

#[cfg(test)]
mod tests;
