//! The film on its way to tev: one frame after the other, in the background, while that is wanted.

use std::time::{Duration, Instant};

use egui::Context;
use neumann_core::film::Film;
use neumann_picture::PictureError;
use neumann_picture::tev::{DEFAULT_ADDRESS, Tev, image_name};

use crate::notices::Notices;
use crate::session::Session;

/// Between two frames,
const PERIOD: Duration = Duration::from_millis(300);
/// or so many times what sending one takes, if that is longer.
const SEND_TIMES: u32 = 10;
/// How the notice begins that says that it has begun.
const BEGUN: &str = "The picture goes to tev";

/// Whether the film is sent, and what of it was.
pub struct Sending {
    /// Where tev listens.
    pub address: String,
    line: Line,
    /// Version of the picture that was sent last.
    sent: Option<u64>,
    /// The next frame is not sent before.
    rests_until: Option<Instant>,
    /// How often it was turned on or off: what comes of an earlier time is of no interest.
    n_turns: u64,
}

/// The line to tev.
#[derive(Default)]
enum Line {
    /// Nobody wants one.
    #[default]
    Off,
    /// It is wanted.
    Wanted,
    /// An errand has it.
    Away,
    /// It is there.
    Idle(Box<Tev>),
}

/// What is to be done in the background.
pub struct Errand {
    n_turns: u64,
    begun: Instant,
    what: What,
}

enum What {
    /// Seek tev at an address.
    Seek(String),
    /// Send a film under a name.
    Send(Box<Tev>, String, Box<Film>),
}

/// What came of it.
pub struct Outcome {
    n_turns: u64,
    result: Result<Box<Tev>, PictureError>,
    /// How long sending took; `None` if tev was sought.
    took: Option<Duration>,
}

impl Errand {
    /// Does it.
    #[must_use]
    pub fn run(self) -> Outcome {
        let (result, is_sent) = match self.what {
            What::Seek(address) => (Tev::connect(&address).map(Box::new), false),
            What::Send(mut tev, name, film) => (tev.show(&name, &film).map(|()| tev), true),
        };
        Outcome {
            n_turns: self.n_turns,
            result,
            took: is_sent.then(|| self.begun.elapsed()),
        }
    }
}

impl Default for Sending {
    fn default() -> Self {
        Self {
            address: DEFAULT_ADDRESS.to_owned(),
            line: Line::Off,
            sent: None,
            rests_until: None,
            n_turns: 0,
        }
    }
}

impl Sending {
    /// True from the key that asks for it to that which ends it.
    #[must_use]
    pub fn is_on(&self) -> bool {
        !matches!(self.line, Line::Off)
    }

    /// Begins, or ends.
    pub fn toggle(&mut self, ctx: &Context, notices: &mut Notices) {
        let was_on = self.is_on();
        *self = Self {
            address: std::mem::take(&mut self.address),
            line: if was_on { Line::Off } else { Line::Wanted },
            n_turns: self.n_turns + 1,
            ..Self::default()
        };
        if was_on {
            let text = "tev gets no more pictures".to_owned();
            notices.remark_instead(ctx, &[BEGUN], text);
        }
    }

    /// What is to be done now, if anything is: the picture is sent if it has changed, and if the
    /// last time is long enough ago.
    pub fn next_errand(&mut self, session: &Session) -> Option<Errand> {
        let begun = Instant::now();
        let what = match &self.line {
            Line::Wanted => What::Seek(self.address.clone()),
            Line::Idle(_) if self.has_news(session) && self.rest(session).is_none() => {
                let (film, metadata) = session.film()?;
                let name = image_name(&metadata.scene, &metadata.integrator);
                let Line::Idle(tev) = std::mem::take(&mut self.line) else {
                    return None;
                };
                self.sent = Some(session.picture.version);
                What::Send(tev, name, Box::new(film))
            }
            _ => return None,
        };
        self.line = Line::Away;
        Some(Errand {
            n_turns: self.n_turns,
            begun,
            what,
        })
    }

    /// How long to wait where it is too early to send what has come.
    #[must_use]
    pub fn rest(&self, session: &Session) -> Option<Duration> {
        let rest = self.rests_until?.saturating_duration_since(Instant::now());
        let is_waiting = matches!(self.line, Line::Idle(_)) && self.has_news(session);
        (is_waiting && !rest.is_zero()).then_some(rest)
    }

    fn has_news(&self, session: &Session) -> bool {
        session.picture.is_there() && self.sent != Some(session.picture.version)
    }

    /// Takes the line back, or says that there is none.
    pub fn take(&mut self, ctx: &Context, outcome: Outcome, notices: &mut Notices) {
        if outcome.n_turns != self.n_turns {
            return;
        }
        let address = &self.address;
        match outcome.result {
            Ok(tev) => {
                self.line = Line::Idle(tev);
                if let Some(took) = outcome.took {
                    self.rests_until = Some(Instant::now() + PERIOD.max(SEND_TIMES * took));
                } else {
                    let text = format!("{BEGUN} at {address}; Ctrl Shift T ends it");
                    notices.remark(ctx, text);
                }
            }
            Err(error) => {
                self.line = Line::Off;
                notices.failure(match error {
                    PictureError::NoTev { .. } => {
                        format!("No tev listens at {address}; start it, then press Ctrl Shift T")
                    }
                    _ => format!("{error}; Ctrl Shift T begins again"),
                });
            }
        }
    }
}
