//! `plot sky`, `plot body`: the pictures of `map`, with the map as a table beside.

use super::arguments::{PictureArguments, PlotBodyArguments, PlotSkyArguments};
use crate::failure::Outcome;
use crate::verbs::map::{MapBodyArguments, MapOutputArguments, MapSkyArguments};

use super::target::{Target, name_beside, only};

pub fn sky(typed: PlotSkyArguments) -> anyhow::Result<Outcome> {
    crate::verbs::map::sky(MapSkyArguments { view: typed.view, output: beside(&typed.picture)? })
}

pub fn body(typed: PlotBodyArguments) -> anyhow::Result<Outcome> {
    crate::verbs::map::body(MapBodyArguments { view: typed.view, output: beside(&typed.picture)? })
}

/// Where `map` puts picture and table.
fn beside(typed: &PictureArguments) -> anyhow::Result<MapOutputArguments> {
    let picture = only(typed)?;
    Target::new(typed)?;
    let data = typed.data.clone().or_else(|| (!typed.no_data).then(|| name_beside(&picture)));
    Ok(MapOutputArguments { step_deg: None, nside: None, format: None, output: data, picture: Some(picture) })
}
