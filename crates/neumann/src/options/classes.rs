//! Layers beside the bounces: classes of paths, and the light of each source.

use clap::Args;
use neumann_core::expression::Expression;
use neumann_core::film::{LightGroup, PathClasses};
use neumann_core::radiometry::Rgb;
use neumann_core::scene::Scene;

use crate::console;
use crate::failure::{OrBadInput, Outcome, bad_input};

/// Which layers are kept.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Layers beside the bounces")]
pub(crate) struct ClassOptions {
    /// Keep a class of paths apart: a light path expression such as 'L S+ D E', with a name before
    /// it ('glints=L S+ D E'), or one that has a name ('neumann list expressions'); up to 32 times.
    /// Rendering takes about twice as long
    #[arg(long = "expression", value_name = "[NAME=]EXPRESSION")]
    pub(crate) expressions: Vec<String>,
    /// Keep the light of each source apart ('each'), or of groups:
    /// 'warm=lamp,candle;sky=environment'
    #[arg(long, value_name = "each|GROUPS")]
    pub(crate) lights: Option<String>,
    /// Multiply the light of a source or group in what is shown: a number, or R,G,B; up to once for
    /// each. An .exr has that as the layer 'mix'
    #[arg(long, value_name = "LIGHT=FACTOR", requires = "lights", value_parser = factor)]
    pub(crate) mix: Vec<(String, Rgb)>,
}

impl ClassOptions {
    /// The layers, if there are any.
    pub(crate) fn resolve(&self, scene: &Scene) -> Outcome<Option<PathClasses>> {
        let read = |text: &String| {
            Expression::new(text, scene).map_err(|error| {
                console::note(&error.marked());
                bad_input(format!("--expression {error}"))
            })
        };
        let expressions: Outcome<Vec<Expression>> = self.expressions.iter().map(read).collect();
        let lights = self.lights.as_deref();
        let groups = lights.map(|text| {
            LightGroup::parse(text, scene).map_err(|error| bad_input(format!("--lights: {error}")))
        });
        let classes = PathClasses {
            expressions: expressions?,
            groups: groups.transpose()?.unwrap_or_default(),
        };
        classes.check().or_bad_input()?;
        self.factors(&classes)?;
        Ok(Some(classes).filter(|classes| !classes.is_empty()))
    }

    /// A factor for each group, and for all other light; none if nothing is mixed.
    pub(crate) fn factors(&self, classes: &PathClasses) -> Outcome<Vec<Rgb>> {
        if self.mix.is_empty() {
            return Ok(Vec::new());
        }
        let names = classes.groups.iter().map(|group| group.name.as_str());
        let names: Vec<&str> = names.chain([LightGroup::OTHERS]).collect();
        let mut factors = vec![Rgb::WHITE; names.len()];
        for (name, factor) in &self.mix {
            let Some(group) = names.iter().position(|other| other == name) else {
                return Err(bad_input(format!(
                    "--mix: '{name}' is no group of lights; there are '{}'",
                    names.join("', '")
                )));
            };
            factors[group] = *factor;
        }
        Ok(factors)
    }
}

/// `LIGHT=FACTOR`.
fn factor(text: &str) -> Result<(String, Rgb), String> {
    let parse = || {
        let (name, factor) = text.rsplit_once('=')?;
        let parts: Option<Vec<f32>> = factor.split(',').map(|p| p.trim().parse().ok()).collect();
        let color = match *parts? {
            [all] => Rgb::splat(all),
            [r, g, b] => Rgb::new(r, g, b),
            _ => return None,
        };
        let is_factor = color.is_radiance() && !name.trim().is_empty();
        is_factor.then(|| (name.trim().to_owned(), color))
    };
    parse().ok_or_else(|| "use LIGHT=FACTOR, such as lamp=0.5 or lamp=1,0.8,0.6".to_owned())
}
