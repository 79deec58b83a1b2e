//! Steps of one level.

use super::border::{self, Left};
use super::consts::Consts;
use super::held::{Held, Swept};
use super::sweep::{REACH, STATE, Sweep};
use super::{Settings, Site, State};
use crate::kit::erosion::band::Bands;
use crate::kit::erosion::prolong::sum;
use crate::kit::simd::Level;
use crate::work::{Cancelled, Work};

/// What a level got and gave, in m³.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Account {
    /// Water that fell as rain or came from sources.
    pub rained: f64,
    /// Water that went into the air.
    pub evaporated: f64,
    /// Water that the sea took to keep its level; what it gave is below 0.
    pub drowned: f64,
    /// Water that left over an open border.
    pub water_left: f64,
    /// Solid that left over an open border.
    pub solid_left: f64,
}

/// Steps of one level, with room for what they work on.
#[derive(Debug)]
pub struct Run {
    site: Site,
    state: State,
    consts: Consts,
    bands: Bands<STATE, Held>,
    account: Account,
    /// Rain of a second, in metres summed over cells.
    falls: f64,
    level: Level,
}

impl Run {
    /// A level, from a state on, in steps of so many seconds.
    pub fn new(mut site: Site, state: State, settings: &Settings, dt: f64) -> Self {
        site.open &= border::has_inside(&site);
        let bands = Bands::new(site.cols, site.rows, REACH, || Held::new(site.cols));
        let consts = Consts::new(settings, site.cell, dt, site.sea);
        let falls = sum(&site.rain, |rain| rain);
        Self { site, state, consts, bands, account: Account::default(), falls, level: Level::best() }
    }

    /// The same, compiled for an instruction set.
    #[must_use]
    pub fn on(mut self, level: Level) -> Self {
        self.level = level;
        self
    }

    /// What the level is given.
    pub fn site(&self) -> &Site {
        &self.site
    }

    /// What has become of it.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// What it got and gave so far.
    pub fn account(&self) -> &Account {
        &self.account
    }

    /// Length of a step, in seconds.
    pub fn dt(&self) -> f64 {
        f64::from(self.consts.dt)
    }

    /// Site and state, as they are.
    pub fn into_parts(self) -> (Site, State) {
        (self.site, self.state)
    }

    /// Other rain from now on: in m/s for each cell, or none at all.
    ///
    /// # Panics
    /// When there is not one value per cell.
    pub fn rain(&mut self, rain: Option<Vec<f32>>) {
        self.consts.rains = rain.is_some();
        if let Some(rain) = rain {
            assert_eq!(rain.len(), self.site.len(), "one value per cell");
            self.falls = sum(&rain, |rain| rain);
            self.site.rain = rain;
        }
    }

    /// Takes a step.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn step(&mut self, work: &Work<'_>) -> Result<(), Cancelled> {
        work.check()?;
        if self.site.is_empty() {
            return Ok(());
        }
        let (site, consts, level) = (&self.site, self.consts, self.level);
        self.bands.sweep(self.state.all_mut(), |band, held| level.run(Sweep { site, consts, band, held }));
        self.book();
        Ok(())
    }

    /// Takes account of a step, and clears the border.
    fn book(&mut self) {
        let area = self.site.cell_area();
        let left =
            if self.site.open { border::clear(&self.site, &mut self.state) } else { Left::default() };
        let sum = |of: fn(&Swept) -> &[f64]| -> f64 {
            self.bands.held().flat_map(|held| of(&held.swept)).sum::<f64>() * area
        };
        let (evaporated, sea) = (sum(|swept| &swept.evaporated), sum(|swept| &swept.sea));
        let rained = if self.consts.rains { self.falls * self.dt() } else { 0.0 };
        let account = &mut self.account;
        account.rained += rained * area;
        account.evaporated += evaporated;
        account.drowned += sea;
        account.water_left += left.water * area;
        account.solid_left += left.solid * area;
    }
}
