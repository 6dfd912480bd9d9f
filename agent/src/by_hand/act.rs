//! Changes by hand of what runs, as rtact, rtdeact, rtreset, rtconf, rtcon and rtdis make them.
//!
//! Each is one request to a manager. With it goes a mark that says what was desired at that moment, so that planners can
//! tell what a person changed ([`rts_plan::observed::ByHand`]).

mod configure;
mod connect;
mod disconnect;
mod state;
mod subject;

use std::sync::Arc;

use rts_agent_api::messages::{Act, ActRequest, Acted};
use rts_http::problem::Problem;

use crate::agent::Agent;

impl Agent {
    /// Does what a person wants, or only checks whether it can be done. Refused (with a problem) is what makes no sense
    /// here and now, and what the manager or the component refuses.
    pub async fn act_by_hand(self: &Arc<Self>, request: ActRequest) -> Result<Acted, Problem> {
        let dry_run = request.dry_run;
        let acted = match request.act {
            Act::Activate { instance } => self.activate_by_hand(&instance, dry_run).await,
            Act::Deactivate { instance } => self.deactivate_by_hand(&instance, dry_run).await,
            Act::Reset { instance } => self.reset_by_hand(&instance, dry_run).await,
            Act::Tick { instance, cycles } => self.tick_by_hand(&instance, cycles, dry_run).await,
            Act::Configure {
                instance,
                set,
                values,
                active,
            } => {
                let wish = configure::Wish {
                    set,
                    values,
                    active,
                };
                self.configure_by_hand(&instance, wish, dry_run).await
            }
            Act::Connect {
                source,
                target,
                name,
                properties,
            } => {
                let wish = connect::Wish {
                    source,
                    target,
                    name,
                    properties,
                };
                self.connect_by_hand(wish, dry_run).await
            }
            Act::Disconnect {
                instance,
                connector,
            } => self.disconnect_by_hand(&instance, connector, dry_run).await,
        };
        if !dry_run {
            // What failed may have changed something, too.
            self.dirty.notify_one();
        }
        acted
    }
}
