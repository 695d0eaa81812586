//! What a long call says while it runs.
//!
//! In: a function that receives events. Out: a [`Progress`] to hand down: a part of the work by name, and the fraction of it
//! that is done. Events may be sent from any thread.

use std::sync::Mutex;

/// An event of a long call.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event<'a> {
    /// A part of the work begins.
    Part(&'static str),
    /// This fraction of the part is done, 0 to 1.
    Fraction(f64),
    /// Something worth a line.
    Note(&'a str),
}

/// What receives the events.
type Receiver<'a> = Box<dyn FnMut(Event<'_>) + Send + 'a>;

/// Where a long call sends its events. See the module header.
pub struct Progress<'a> {
    receive: Option<Mutex<Receiver<'a>>>,
}

impl<'a> Progress<'a> {
    /// Sends events to `receive`.
    pub fn new(receive: impl FnMut(Event<'_>) + Send + 'a) -> Self {
        Self { receive: Some(Mutex::new(Box::new(receive))) }
    }

    /// Drops all events.
    pub fn silent() -> Self {
        Self { receive: None }
    }

    /// Sends an event. After a receiver has panicked, events are dropped.
    pub fn send(&self, event: Event<'_>) {
        if let Some(receive) = &self.receive
            && let Ok(mut receive) = receive.lock()
        {
            receive(event);
        }
    }

    /// A part of the work begins.
    pub fn part(&self, name: &'static str) {
        self.send(Event::Part(name));
    }

    /// This fraction of the part is done.
    pub fn at(&self, fraction: f64) {
        self.send(Event::Fraction(fraction));
    }
}
