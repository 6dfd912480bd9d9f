//! Commands of the transcripts, carried out on a simulated world.

mod describe;

use rts_plan::observed::LifeCycleState;
use rts_plan::plan::{Blocked, Plan};
use rts_plan::{check_orders, plan, target};
use rts_schemas::placement;

use crate::world::World;
use crate::world::execute::Chance;
use crate::world::specs::set;
use crate::world::story::tell;

/// Why a script cannot be played.
pub type Fault = String;

/// A world of two nodes and what the scripts have arranged for it.
pub struct Stage {
    world: World,
    blocked: Blocked,
    /// `Kind target` of steps that fail in the next run.
    failing: Vec<String>,
}

impl Stage {
    pub fn new() -> Self {
        Self {
            world: World::new(&["local", "robot"]),
            blocked: Blocked::new(),
            failing: Vec::new(),
        }
    }

    /// Carries out one command and gives what it answers, each line ended.
    pub fn carry_out(&mut self, command: &str, more: &[&str]) -> Result<String, Fault> {
        let words: Vec<&str> = command.split_whitespace().collect();
        match words.as_slice() {
            ["apply", "export"] => return self.export(),
            ["apply", name] => return self.apply(name, more),
            ["teardown", name] => self.world.delete(name),
            ["set", instance, word] => return self.set(instance, word),
            ["drop", instance] => self.drop(instance)?,
            ["property", connector, word] => self.property(connector, word)?,
            ["module", type_name] => self.module(type_name)?,
            ["plan"] => return Ok(tell(&self.plan())),
            ["run"] => return self.run(),
            ["settle"] => return self.settle(),
            ["explain", step] => return self.explain(step),
            ["fails", kind, target] => self.failing.push(format!("{kind} {target}")),
            ["block", node, target, why @ ..] => {
                let key = target::on(node, target);
                self.blocked.insert(key, why.join(" "));
            }
            ["unblock"] => self.blocked.clear(),
            ["kill", manager] => self.kill(manager)?,
            ["error", instance, why @ ..] => self.error(instance, &why.join(" "))?,
            ["silent", "node", node] => drop(self.world.silent.insert((*node).to_owned())),
            ["back", "node", node] => drop(self.world.silent.remove(*node)),
            ["by", "hand", rest @ ..] => return self.by_hand(rest),
            _ => return Err(format!("what is `{command}`?")),
        }
        Ok(String::new())
    }

    fn plan(&self) -> Plan {
        let (desired, observed) = (self.world.desired(), self.world.observed());
        plan(&desired, &observed, &self.blocked)
    }

    fn apply(&mut self, name: &str, lines: &[&str]) -> Result<String, Fault> {
        let system = describe::system(name, lines)?;
        let cycles = check_orders(&system.spec);
        if cycles.is_empty() {
            self.world.apply(system);
            return Ok(String::new());
        }
        Ok(cycles.iter().map(|e| format!("refused: {e}\n")).collect())
    }

    /// Changes a setting of a component in the system, as an edit of its file would.
    fn set(&mut self, instance: &str, word: &str) -> Result<String, Fault> {
        let (key, value) = pair(word)?;
        let mut components = self.world.systems.iter_mut();
        let component = components
            .find_map(|s| {
                s.spec
                    .components
                    .iter_mut()
                    .find(|c| c.instance == instance)
            })
            .ok_or_else(|| format!("there is no {instance}"))?;
        match key {
            "rate" => component.execution_context.rate = Some(number(value)?),
            "active" => component.configuration.active = Some(value.to_owned()),
            "type" => {
                component.type_name = value.to_owned();
                let system = self.world.systems.iter_mut();
                for system in system {
                    let digests = &mut system.module_digests;
                    digests
                        .entry(value.to_owned())
                        .or_insert(format!("digest-{value}-0"));
                }
            }
            key if placement::KEYS.contains(&key) => {
                placement::set(component, key, value).map_err(|e| e.message)?;
            }
            key => set(component, key, value),
        }
        Ok(String::new())
    }

    /// Takes a component and its connectors out of its system.
    fn drop(&mut self, instance: &str) -> Result<(), Fault> {
        let mut systems = self.world.systems.iter_mut().map(|s| &mut s.spec);
        let spec = systems
            .find(|s| s.components.iter().any(|c| c.instance == instance))
            .ok_or_else(|| format!("there is no {instance}"))?;
        spec.components.retain(|c| c.instance != instance);
        spec.connectors
            .retain(|c| c.source.instance != instance && c.target.instance != instance);
        Ok(())
    }

    fn property(&mut self, connector: &str, word: &str) -> Result<(), Fault> {
        let (key, value) = pair(word)?;
        let mut all = self
            .world
            .systems
            .iter_mut()
            .flat_map(|s| &mut s.spec.connectors);
        let connector = all
            .find(|c| c.name == connector)
            .ok_or_else(|| format!("there is no {connector}"))?;
        connector
            .properties
            .insert(key.to_owned(), value.to_owned());
        Ok(())
    }

    /// The module file of a type is another by now.
    fn module(&mut self, type_name: &str) -> Result<(), Fault> {
        let mut digests = self
            .world
            .systems
            .iter_mut()
            .filter_map(|s| s.module_digests.get_mut(type_name));
        let digest = digests
            .next()
            .ok_or_else(|| format!("there is no {type_name}"))?;
        digest.push('x');
        Ok(())
    }

    /// Carries out the present plan; what fails is blocked from then on.
    fn run(&mut self) -> Result<String, Fault> {
        let plan = self.plan();
        let failing = std::mem::take(&mut self.failing);
        let chance = Chance {
            pick: &mut |_| 0,
            fails: &mut |step| {
                let name = format!("{} {}", step.work.kind(), step.target);
                failing.contains(&name)
            },
        };
        let run = self.world.execute(&plan, chance)?;
        let answer = run
            .failed
            .iter()
            .map(|(target, why)| format!("failed: {target}: {why}\n"));
        let answer = answer.collect();
        self.blocked = run.failed;
        Ok(answer)
    }

    /// Plans and runs until nothing is left to do.
    fn settle(&mut self) -> Result<String, Fault> {
        self.blocked.clear();
        for round in 0..8 {
            let plan = self.plan();
            if plan.steps.is_empty() {
                return Ok(format!("settled after {round} plans\n{}", tell(&plan)));
            }
            self.run()?;
        }
        Err(format!("no end:\n{}", self.plan()))
    }

    fn explain(&self, step: &str) -> Result<String, Fault> {
        let plan = self.plan();
        let step = step.parse().map_err(|_| format!("{step} is no number"))?;
        let explained = rts_plan::explain::explain(&plan, step);
        let explained = explained.ok_or_else(|| format!("there is no step {step}"))?;
        Ok(rts_plan::explain::render_step(&explained))
    }

    fn kill(&mut self, manager: &str) -> Result<(), Fault> {
        let mut all = self.world.managers();
        let nth = all.position(|(_, m)| m.key.display_name() == manager);
        let nth = nth.ok_or_else(|| format!("no manager {manager} runs"))?;
        drop(all);
        self.world.kill(nth);
        self.world.notice();
        Ok(())
    }

    fn error(&mut self, instance: &str, why: &str) -> Result<(), Fault> {
        let mut all = self.world.components_mut();
        let component = all.find(|c| c.instance == instance);
        let component = component.ok_or_else(|| format!("there is no {instance}"))?;
        component.state = LifeCycleState::Error;
        component.message = Some(why.to_owned());
        Ok(())
    }

    /// What a person does; the connectors are given by their ends.
    fn by_hand(&mut self, words: &[&str]) -> Result<String, Fault> {
        let desired = self.world.desired();
        let found = |instance: &str| {
            let found = self.world.component(instance).cloned();
            found.ok_or_else(|| format!("there is no {instance}"))
        };
        match words {
            ["set", instance, word] => {
                let (set, value) = pair(word)?;
                let found = found(instance)?;
                self.world.set_by_hand(&desired, &found, set, value);
            }
            ["deactivate", instance] => {
                let found = found(instance)?;
                self.world.deactivate_by_hand(&desired, &found);
            }
            ["connect", source, target, word] => {
                let (_, how) = pair(word)?;
                let (source, target) = (found(source)?, found(target)?);
                self.world.connect_by_hand(&desired, &source, &target, how);
            }
            ["disconnect", source, target] => {
                let source = found(source)?;
                let name = format!("{}.out-{target}.in", source.instance);
                self.world.disconnect_by_hand(&desired, &source, &name);
            }
            _ => return Err(format!("what is `by hand {}`?", words.join(" "))),
        }
        Ok(String::new())
    }

    /// What `rtsctl export` would write, applied again.
    fn export(&mut self) -> Result<String, Fault> {
        let drift = self.plan().drift;
        let mut notes = Vec::new();
        for system in &mut self.world.systems {
            let (spec, more) = rts_plan::with_drift(&system.spec, &drift, |_| true);
            system.spec = spec;
            notes.extend(more.into_iter().map(|note| format!("note: {note}\n")));
        }
        Ok(notes.concat())
    }
}

/// `key=value`
fn pair(word: &str) -> Result<(&str, &str), Fault> {
    word.split_once('=')
        .ok_or_else(|| format!("`{word}` is not key=value"))
}

fn number(text: &str) -> Result<f64, Fault> {
    text.parse().map_err(|_| format!("`{text}` is no number"))
}
