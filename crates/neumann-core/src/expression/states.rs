//! The automaton made deterministic: for each state and each kind of bounce, the one state that
//! follows (the subset construction of M. Rabin and D. Scott, Finite Automata and Their Decision
//! Problems, IBM Journal 3(2), 1959). A path takes one step a bounce then, and a bounce that lobes
//! have in common can go each lobe's way, with its share: no path is counted twice.

use std::collections::HashMap;

use super::Pattern;
use super::automaton::{Automaton, Step};
use crate::radiometry::Rgb;
use crate::transport::{Bounce, Lobe, Scattered};

/// Takes rows of bounces, one step each.
#[derive(Clone, Debug)]
pub(super) struct States {
    /// `next[state * n_kinds + kind]`
    next: Vec<u32>,
    n_kinds: usize,
    /// `accepted[state]`: which of the alternatives it takes, a bit for each.
    accepted: Vec<u64>,
    /// Materials that patterns tell from the others, by number; those have number 0.
    classes: HashMap<u32, usize>,
}

/// Where no way leads on.
const DEAD: u32 = u32::MAX;

/// Lobes times directions.
const WAYS: usize = 6;

impl States {
    /// States, at most.
    const MAX: usize = 4096;
    /// Steps that are looked at to make them, at most: a few seconds' work.
    const MAX_WORK: usize = 1 << 27;

    /// Of automata side by side, 64 at most; `None` if they would be too many.
    pub(super) fn new(automata: &[Automaton]) -> Option<Self> {
        let (classes, examples) = classes(automata);
        let kinds: Vec<Bounce> = examples.iter().flat_map(|m| ways_of(*m)).collect();
        let mut states = Self {
            next: Vec::new(),
            n_kinds: kinds.len(),
            accepted: Vec::new(),
            classes,
        };
        let mut known: HashMap<Vec<(u32, u32)>, u32> = HashMap::new();
        let mut waiting: Vec<Vec<(u32, u32)>> = Vec::new();
        let mut work = 0;
        let mut number_of = |set: Vec<(u32, u32)>, waiting: &mut Vec<_>| {
            if set.is_empty() {
                return Some(DEAD);
            }
            let n = known.len() as u32;
            Some(*known.entry(set).or_insert_with_key(|set| {
                waiting.push(set.clone());
                n
            }))
            .filter(|_| n < Self::MAX as u32)
        };
        let starts = automata.iter().zip(0..).flat_map(|(automaton, of)| {
            let entered = automaton.entered([automaton.start]);
            entered.into_iter().map(move |step| (of, step))
        });
        number_of(starts.collect(), &mut waiting)?;
        let mut done = 0;
        while done < waiting.len() {
            let set = waiting[done].clone();
            done += 1;
            let accepted = set.iter().filter(|(_, step)| *step == 0);
            states
                .accepted
                .push(accepted.fold(0, |bits, (of, _)| bits | 1 << of));
            for kind in &kinds {
                let mut next = Vec::new();
                for (automaton, of) in automata.iter().zip(0..) {
                    let here = set.iter().filter(|(other, _)| *other == of);
                    let taken = here.filter_map(|(_, step)| automaton.after(*step, kind));
                    let entered = automaton.entered(taken);
                    work += set.len() + entered.len();
                    next.extend(entered.into_iter().map(|step| (of, step)));
                }
                if work > Self::MAX_WORK {
                    return None;
                }
                states.next.push(number_of(next, &mut waiting)?);
            }
        }
        Some(states)
    }

    fn step(&self, state: u32, bounce: &Bounce, lobe: Lobe) -> u32 {
        let material = bounce.material.and_then(|m| self.classes.get(&m));
        let way = 2 * lobe as usize + usize::from(bounce.is_transmission);
        let kind = WAYS * material.copied().unwrap_or(0) + way;
        self.next[state as usize * self.n_kinds + kind]
    }

    /// The alternatives that take a whole row, a bit for each.
    pub(super) fn accepted<'a>(&self, bounces: impl Iterator<Item = &'a Bounce>) -> u64 {
        let mut state = 0;
        for bounce in bounces {
            state = self.step(state, bounce, bounce.lobe);
            if state == DEAD {
                return 0;
            }
        }
        self.accepted[state as usize]
    }

    /// Share of a whole row that some of the alternatives take, per channel.
    pub(super) fn share<'a>(
        &self,
        row: impl Iterator<Item = &'a Scattered>,
        alternatives: u64,
    ) -> Rgb {
        let mut now = vec![(0, Rgb::WHITE)];
        let mut next: Vec<(u32, Rgb)> = Vec::new();
        for scattered in row {
            for (state, share) in now.drain(..) {
                for (lobe, of_lobe) in scattered.lobes() {
                    let to = self.step(state, &scattered.bounce, lobe);
                    let share = share * of_lobe;
                    match next.iter_mut().find(|(other, _)| *other == to) {
                        _ if to == DEAD => {}
                        Some((_, sum)) => *sum += share,
                        None => next.push((to, share)),
                    }
                }
            }
            std::mem::swap(&mut now, &mut next);
        }
        let taken = now
            .iter()
            .filter(|(state, _)| self.accepted[*state as usize] & alternatives != 0);
        taken.fold(Rgb::BLACK, |sum, (_, share)| sum + *share)
    }
}

/// Sorts materials by which patterns name them; yields an example of each kind, that of no pattern
/// first.
fn classes(automata: &[Automaton]) -> (HashMap<u32, usize>, Vec<Option<u32>>) {
    let steps = automata.iter().flat_map(|automaton| &automaton.steps);
    let patterns = steps.filter_map(|step| match step {
        Step::Take { patterns, .. } => Some(patterns),
        _ => None,
    });
    let named = patterns
        .flatten()
        .filter_map(|Pattern { materials, .. }| materials.as_ref());
    let mut lists: Vec<&Vec<u32>> = named.collect();
    lists.sort_unstable();
    lists.dedup();
    let mut of_material: HashMap<u32, Vec<usize>> = HashMap::new();
    for (number, list) in lists.iter().enumerate() {
        for material in *list {
            of_material.entry(*material).or_default().push(number);
        }
    }
    let mut examples = vec![None];
    let mut numbers: HashMap<Vec<usize>, usize> = HashMap::new();
    let mut classes = HashMap::new();
    let mut all: Vec<_> = of_material.into_iter().collect();
    all.sort_unstable();
    for (material, lists) in all {
        let class = *numbers.entry(lists).or_insert_with(|| {
            examples.push(Some(material));
            examples.len() - 1
        });
        classes.insert(material, class);
    }
    (classes, examples)
}

/// All that may happen at a material, in the order of lobes, reflection first.
fn ways_of(material: Option<u32>) -> impl Iterator<Item = Bounce> {
    let lobes = [Lobe::Diffuse, Lobe::Glossy, Lobe::Specular];
    lobes.into_iter().flat_map(move |lobe| {
        [false, true].map(|is_transmission| Bounce {
            lobe,
            is_transmission,
            material,
        })
    })
}
