//! Steps of one level.

use super::border::{self, Left};
use super::consts::{Consts, THINNEST};
use super::held::{Held, Swept};
use super::sweep::{REACH, STATE, Sweep};
use super::{Settings, Site, State};
use crate::kit::erosion::band::Bands;
use crate::kit::erosion::slippage::{PACE, Repose, Slippage, Slopes};
use crate::kit::flow::neighbor::Cells;
use crate::kit::simd::Level;
use crate::work::{Cancelled, Work};

/// How fast what is too steep falls, as a diffusivity in m²/s: slowly against water, or it would flatten the land.
const SLIPPAGE: f64 = 20.0;

/// Fewest and most steps of water between two of slippage.
const OFTEN: f64 = 4.0;
const SELDOM: f64 = 64.0;

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
    /// Water that finer levels began with beyond that of the coarser ones: their lakes have other shores.
    pub refined: f64,
}

impl std::ops::AddAssign for Account {
    fn add_assign(&mut self, other: Self) {
        self.rained += other.rained;
        self.evaporated += other.evaporated;
        self.drowned += other.drowned;
        self.water_left += other.water_left;
        self.solid_left += other.solid_left;
        self.refined += other.refined;
    }
}

/// How slopes fall beside the water.
#[derive(Clone, Copy, Debug)]
struct Slides {
    /// Tangents of the angles of repose of rock and loose ground.
    rock: f32,
    loose: f32,
    /// Steps of water between two of slippage, and the share of the excess that moves in one.
    every: usize,
    pace: f32,
}

impl Slides {
    fn new(settings: &Settings, cell: f64, dt: f64) -> Self {
        let share = SLIPPAGE * dt / (cell * cell);
        let every = (f64::from(PACE) / share).clamp(OFTEN, SELDOM) as usize;
        let pace = (share * every as f64).min(f64::from(PACE)) as f32;
        Self { rock: settings.rock_repose as f32, loose: settings.loose_repose as f32, every, pace }
    }
}

/// Steps of one level, with room for what they work on.
#[derive(Debug)]
pub struct Run {
    site: Site,
    state: State,
    consts: Consts,
    bands: Bands<STATE, Held>,
    account: Account,
    level: Level,
    slides: Slides,
    slippage: Slippage,
    /// Steps taken.
    steps: usize,
}

impl Run {
    /// Depth in metres below which water does not run.
    pub const THINNEST: f32 = THINNEST;

    /// A level, from a state on, in steps of so many seconds.
    pub fn new(mut site: Site, state: State, settings: &Settings, dt: f64) -> Self {
        site.open &= border::has_inside(&site);
        let bands = Bands::new(site.cols, site.rows, REACH, || Held::new(site.cols));
        let consts = Consts::new(settings, site.cell, dt, site.sea);
        let slippage = Slippage::new(Cells { cols: site.cols, rows: site.rows });
        let slides = Slides::new(settings, site.cell, dt);
        let (account, level, steps) = (Account::default(), Level::best(), 0);
        Self { site, state, consts, bands, account, level, slides, slippage, steps }
    }

    /// The same, compiled for an instruction set.
    #[must_use]
    pub fn on(mut self, level: Level) -> Self {
        self.level = level;
        self.slippage = self.slippage.on(level);
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
        self.steps += 1;
        if self.steps.is_multiple_of(self.slides.every) { self.slip(work) } else { Ok(()) }
    }

    /// Lets slopes fall that are too steep.
    fn slip(&mut self, work: &Work<'_>) -> Result<(), Cancelled> {
        let (site, slides) = (&self.site, self.slides);
        let slopes = Slopes {
            cells: Cells { cols: site.cols, rows: site.rows },
            cell: site.cell,
            start: &site.height,
            before: site.before.as_deref(),
            rock: Repose::Even(slides.rock),
            loose: Repose::Even(slides.loose),
            mask: site.mask.as_deref(),
            open: site.open,
            pace: slides.pace,
        };
        self.slippage.step(&slopes, [&mut self.state.wear, &mut self.state.loose], work)
    }

    /// Takes account of a step, and clears the border.
    fn book(&mut self) {
        let area = self.site.cell_area();
        let left = if self.site.open { border::clear(&self.site, &mut self.state) } else { Left::default() };
        let sum = |of: fn(&Swept) -> &[f64]| -> f64 {
            self.bands.held().flat_map(|held| of(&held.swept)).sum::<f64>() * area
        };
        let (rained, evaporated) = (sum(|swept| &swept.rained), sum(|swept| &swept.evaporated));
        let sea = sum(|swept| &swept.sea);
        let account = &mut self.account;
        account.rained += rained;
        account.evaporated += evaporated;
        account.drowned += sea;
        account.water_left += left.water * area;
        account.solid_left += left.solid * area;
    }
}
