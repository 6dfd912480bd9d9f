//! An execution context as others see it: the components that it runs, in their order, and the way to its one thread.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex};
use std::time::Instant;

use rts_manager_api::control::{ExecutionContextInfo, ExecutionContextRequest, Failure};

use super::order::place;
use super::{Busy, Component, Order};
use crate::failure::{conflict, invalid};
use crate::module::Execution;
use crate::sync::lock;

/// Requests that may wait for one execution context.
const ORDERS: usize = 128;
/// Components of one execution context; all may be told at once to end.
const MAX_MEMBERS: usize = 64;
/// Longest name.
const MAX_NAME: usize = 128;

/// An execution context.
#[derive(Debug)]
pub struct ExecutionContext {
    /// Its name, by which components share it; none for the own one of a component.
    pub name: Option<String>,
    /// What drives it.
    pub kind: Execution,
    orders: SyncSender<Order>,
    /// Orders that somebody waits for an answer to, and that its thread has not taken.
    asked: AtomicUsize,
    rate: Mutex<Rate>,
    members: Mutex<Vec<Seat>>,
}

/// How often it runs.
#[derive(Debug, Clone, Copy)]
struct Rate {
    hertz: f64,
    /// Somebody asked for it; otherwise it is the highest that a module wants.
    said: bool,
}

/// The rate that a component wants: what was asked for, and what its module has when nothing was.
#[derive(Debug, Clone, Copy)]
pub struct WantedRate {
    /// Asked for.
    pub said: Option<f64>,
    /// Of its module.
    pub default: f64,
}

/// A component on it.
struct Seat {
    number: i32,
    component: Arc<Component>,
}

impl fmt::Debug for Seat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The component would show this execution context.
        write!(f, "{} {}", self.number, self.instance())
    }
}

impl Seat {
    fn instance(&self) -> &str {
        &self.component.identity.instance
    }
}

/// The orders of an execution context that has no thread yet.
pub type NewOrders = Option<Receiver<Order>>;

/// The execution contexts of a manager that have a name. One that is asked for with another kind is another one: the
/// former goes with its last component.
#[derive(Debug, Default)]
pub struct Contexts(Mutex<BTreeMap<(String, &'static str), Arc<ExecutionContext>>>);

impl Contexts {
    /// Makes a component on the execution context that it is to share, or on one of its own.
    pub fn seat(
        &self,
        asked: Option<&ExecutionContextRequest>,
        kind: Execution,
        rate: WantedRate,
        make: impl FnOnce(Arc<ExecutionContext>) -> Component,
    ) -> Result<(Arc<Component>, NewOrders), Failure> {
        if let Some(problem) = asked.and_then(|asked| name_problem(&asked.name)) {
            return Err(invalid(problem));
        }
        let mut known = lock(&self.0);
        let key = asked.map(|asked| (asked.name.clone(), kind.name()));
        let found = key.as_ref().and_then(|key| known.get(key).cloned());
        let (context, orders) = match found {
            Some(context) => (context, None),
            None => {
                let (context, orders) = ExecutionContext::new(asked, kind, rate);
                known.extend(key.map(|key| (key, Arc::clone(&context))));
                (context, Some(orders))
            }
        };
        let mut members = lock(&context.members);
        if members.len() >= MAX_MEMBERS {
            return Err(conflict(format!(
                "{} runs {MAX_MEMBERS} components already; give this one another",
                context.called()
            )));
        }
        let component = Arc::new(make(Arc::clone(&context)));
        put(
            &mut members,
            Seat {
                number: asked.map_or(0, |asked| asked.order),
                component: Arc::clone(&component),
            },
        );
        drop(members);
        Ok((component, orders))
    }

    /// A component is gone. True when it was the last one of its execution context, which ends with it.
    pub fn leave(&self, component: &Arc<Component>) -> bool {
        let context = &component.context;
        let mut known = lock(&self.0);
        let mut members = lock(&context.members);
        members.retain(|seat| !Arc::ptr_eq(&seat.component, component));
        if !members.is_empty() {
            return false;
        }
        known.retain(|_, other| !Arc::ptr_eq(other, context));
        true
    }
}

fn put(members: &mut Vec<Seat>, new: Seat) {
    let others = members.iter().map(|seat| (seat.number, seat.instance()));
    let at = place(others, (new.number, new.instance()));
    members.insert(at, new);
}

fn name_problem(name: &str) -> Option<String> {
    let fits = (1..=MAX_NAME).contains(&name.len()) && !name.chars().any(char::is_control);
    (!fits).then(|| {
        format!(
            "{name:?} cannot name an execution context: use 1 to {MAX_NAME} bytes without control characters"
        )
    })
}

impl ExecutionContext {
    fn new(
        asked: Option<&ExecutionContextRequest>,
        kind: Execution,
        rate: WantedRate,
    ) -> (Arc<Self>, Receiver<Order>) {
        let (orders, received) = sync_channel(ORDERS);
        let context = Arc::new(Self {
            name: asked.map(|asked| asked.name.clone()),
            kind,
            orders,
            asked: AtomicUsize::new(0),
            rate: Mutex::new(Rate {
                hertz: rate.said.unwrap_or(rate.default),
                said: rate.said.is_some(),
            }),
            members: Mutex::default(),
        });
        (context, received)
    }

    /// The rate once a component has come that wants one: what is asked for holds; of the defaults of modules the highest.
    pub(super) fn rate_with(&self, wanted: WantedRate) -> f64 {
        let rate = *lock(&self.rate);
        match (wanted.said, rate.said) {
            (Some(said), _) => said,
            (None, true) => rate.hertz,
            (None, false) => rate.hertz.max(wanted.default),
        }
    }

    /// Rate in Hz.
    pub fn rate(&self) -> f64 {
        lock(&self.rate).hertz
    }

    /// Sets another rate, which somebody asked for or not; returns the former.
    pub(super) fn set_rate(&self, hertz: f64, said: bool) -> f64 {
        let mut rate = lock(&self.rate);
        rate.said |= said;
        std::mem::replace(&mut rate.hertz, hertz)
    }

    /// What it is called in messages.
    pub fn called(&self) -> String {
        match &self.name {
            Some(name) => format!("the execution context `{name}`"),
            None => "its own execution context".to_owned(),
        }
    }

    /// Hands an order to its thread. Never blocks.
    pub fn tell(&self, order: Order) -> Result<(), TrySendError<Order>> {
        let asks = order.asks();
        if asks {
            self.asked.fetch_add(1, Ordering::Relaxed);
        }
        self.orders.try_send(order).inspect_err(|_| {
            if asks {
                self.asked.fetch_sub(1, Ordering::Relaxed);
            }
        })
    }

    /// Its thread has taken an order.
    pub fn taken(&self, order: &Order) {
        if order.asks() {
            self.asked.fetch_sub(1, Ordering::Relaxed);
        }
    }

    /// Whether somebody waits for an answer of its thread.
    pub fn is_asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed) > 0
    }

    /// Gives a component another number.
    pub fn reorder(&self, component: &Arc<Component>, number: i32) {
        let mut members = lock(&self.members);
        let at = members
            .iter()
            .position(|seat| Arc::ptr_eq(&seat.component, component));
        if let Some(at) = at {
            let mut seat = members.remove(at);
            seat.number = number;
            put(&mut members, seat);
        }
    }

    /// The place of a component among all of them.
    pub fn position(&self, component: &Arc<Component>) -> usize {
        let members = lock(&self.members);
        let mut all = members.iter();
        all.position(|seat| Arc::ptr_eq(&seat.component, component))
            .unwrap_or(usize::MAX)
    }

    /// The call that another of its components is in, and whose.
    pub(super) fn held_up_by(&self, component: &Component) -> Option<(String, Busy)> {
        let members = lock(&self.members);
        let others = members.iter().map(|seat| &seat.component);
        let mut others =
            others.filter(|other| other.identity.incarnation != component.identity.incarnation);
        others.find_map(|other| Some((other.identity.instance.clone(), (*lock(&other.busy))?)))
    }

    /// What the inventory shows of it, at a component; nothing of one that is not shared.
    pub(super) fn info(&self, component: &Component) -> Option<ExecutionContextInfo> {
        let name = self.name.clone()?;
        let members = lock(&self.members);
        let own = members
            .iter()
            .find(|seat| seat.component.identity.incarnation == component.identity.incarnation);
        Some(ExecutionContextInfo {
            name,
            order: own.map_or(0, |seat| seat.number),
            shared_state: component.identity.shared_state.clone(),
            members: members
                .iter()
                .map(|seat| seat.instance().to_owned())
                .collect(),
        })
    }
}

impl Component {
    /// Hands an order to its thread, or says why that is not possible.
    pub(super) fn tell(&self, order: Order) -> Result<(), Failure> {
        match self.context.tell(order) {
            Ok(()) => Ok(()),
            Err(TrySendError::Full(_)) => Err(self.late("has too many requests waiting")),
            Err(TrySendError::Disconnected(_)) => Err(self.gone()),
        }
    }

    /// Since when its execution context does something else, in words; none when it does not.
    pub(super) fn waits_for_another(&self) -> Option<String> {
        let (other, Busy { call, since }) = self.context.held_up_by(self)?;
        let running = Instant::now().saturating_duration_since(since);
        Some(format!(
            "waits for {}, where {other} has been in {call} for {:.1} s",
            self.context.called(),
            running.as_secs_f64()
        ))
    }
}
