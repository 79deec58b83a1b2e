//! Steps of one level.

use rayon::prelude::*;

use super::border::{self, Left};
use super::consts::Consts;
use super::held::Held;
use super::sweep::{Band, REACH, STATE, Sweep, Swept};
use super::{Settings, Site, State};
use crate::kit::erosion::prolong::sum;
use crate::kit::simd::Level;
use crate::work::{Cancelled, Work};

/// Most rows of a band: work of one thread, which others may take over.
const BAND: usize = 128;

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
    bands: Vec<Room>,
    account: Account,
    /// Rain of a second, in metres summed over cells.
    falls: f64,
    level: Level,
}

/// What a band has for itself.
#[derive(Debug)]
struct Room {
    rows: [usize; 2],
    halo: [Vec<f32>; 2],
    held: Held,
    swept: Swept,
}

impl Room {
    fn new(site: &Site, rows: [usize; 2]) -> Self {
        let [from, to] = rows;
        let copies = |count: usize| vec![0.0; count * STATE * site.cols];
        let halo = [copies(from.min(REACH)), copies((site.rows - to).min(REACH))];
        Self { rows, halo, held: Held::new(site.cols), swept: Swept::default() }
    }

    /// Copies the rows before and after the band.
    fn look(&mut self, cols: usize, state: &[&[f32]; STATE]) {
        let [from, to] = self.rows;
        for (halo, first) in self.halo.iter_mut().zip([from.saturating_sub(REACH), to]) {
            for (k, row) in halo.chunks_exact_mut(cols.max(1)).enumerate() {
                row.copy_from_slice(&state[k % STATE][(first + k / STATE) * cols..][..cols]);
            }
        }
    }
}

impl Run {
    /// A level, from a state on, in steps of so many seconds.
    pub fn new(mut site: Site, state: State, settings: &Settings, dt: f64) -> Self {
        site.open &= border::has_inside(&site);
        let threads = rayon::current_num_threads();
        let bands = threads * site.rows.div_ceil(threads * BAND).max(1);
        // Bands shorter than twice their reach would work out more rows than their own.
        let tall = site.rows.div_ceil(bands).max(2 * REACH + 2);
        let starts = (0..site.rows).step_by(tall);
        let bands = starts.map(|from| Room::new(&site, [from, (from + tall).min(site.rows)])).collect();
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
        let (site, consts, level, cols) = (&self.site, self.consts, self.level, self.site.cols);
        let whole = self.state.all();
        for room in &mut self.bands {
            room.look(cols, &whole);
        }
        let mut rest = self.state.all_mut();
        let sweeps: Vec<_> = (self.bands.iter_mut())
            .map(|Room { rows, halo, held, swept }| {
                let count = (rows[1] - rows[0]) * cols;
                let state = rest.each_mut().map(|rest| {
                    let (rows, after) = std::mem::take(rest).split_at_mut(count);
                    *rest = after;
                    rows
                });
                swept.clear();
                Sweep { site, consts, band: Band { cols, rows: *rows, state, halo }, held, swept }
            })
            .collect();
        sweeps.into_par_iter().with_max_len(1).for_each(|sweep| level.run(sweep));
        self.book();
        Ok(())
    }

    /// Takes account of a step, and clears the border.
    fn book(&mut self) {
        let area = self.site.cell_area();
        let left =
            if self.site.open { border::clear(&self.site, &mut self.state) } else { Left::default() };
        let sum = |of: fn(&Swept) -> &[f64]| -> f64 {
            self.bands.iter().flat_map(|room| of(&room.swept)).sum::<f64>() * area
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
