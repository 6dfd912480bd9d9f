//! What people write without rtsctl: a shell loop of `ssh host rts-manager …`.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use rts_manager_api::client::Client;
use rts_manager_api::control::{CreateRequest, RequestBody, ResponseBody};
use rts_manager_api::files::CONTROL_SOCKET;
use rts_test_sshd::{HOST, Server};

use super::{MODULE, TYPE};
use crate::project;

/// Bound on each wait.
const PATIENCE: Duration = Duration::from_secs(10);
/// Between two looks for a socket.
const LOOK: Duration = Duration::from_micros(200);

/// One after the other: the shell waits for each `ssh`.
const LOOP: &str = r#"
for i in $(seq "$COUNT"); do
    ssh -F "$CONFIG" "$HOST" "nohup $MANAGER --dir $FOLDER/$i --name m$i </dev/null >/dev/null 2>&1 &"
done"#;
/// All at once.
const AT_ONCE: &str = r#"
for i in $(seq "$COUNT"); do
    ssh -F "$CONFIG" "$HOST" "nohup $MANAGER --dir $FOLDER/$i --name m$i </dev/null >/dev/null 2>&1 &" &
done
wait"#;

/// Starts a manager by SSH for each component, and makes it Active. SSH has no word for the latter: that part is done here
/// over the managers' sockets, on the same machine, which is the best that any script could do.
pub fn launch(
    server: &Server,
    programs: &Path,
    folder: &Path,
    count: u32,
    at_once: bool,
) -> Result<Duration> {
    let folder = tempfile::Builder::new().prefix("s").tempdir_in(folder)?;
    for i in 1..=count {
        std::fs::create_dir(folder.path().join(i.to_string()))?;
    }
    let module = programs.join(MODULE);
    let mut shell = Command::new("sh");
    shell
        .args(["-c", if at_once { AT_ONCE } else { LOOP }])
        .env("COUNT", count.to_string())
        .env("CONFIG", server.config())
        .env("HOST", HOST)
        .env("MANAGER", programs.join("rts-manager"))
        .env("FOLDER", folder.path())
        .stdin(Stdio::null());
    let start = Instant::now();
    project::run(&mut shell)?;
    let managers = (1..=count)
        .map(|i| activate(&folder.path().join(i.to_string()), &module))
        .collect::<Result<Vec<_>>>()?;
    let took = start.elapsed();
    managers.into_iter().try_for_each(end)?;
    Ok(took)
}

/// Makes a component in the manager of a folder, and waits until it is Active.
fn activate(folder: &Path, module: &Path) -> Result<Client> {
    let mut manager = connect(&folder.join(CONTROL_SOCKET))?;
    let instance = "component".to_owned();
    let module = module.to_str().context("a path that is no text")?;
    let requests = [
        RequestBody::LoadModule {
            type_name: TYPE.to_owned(),
            path: module.to_owned(),
            digest: None,
        },
        RequestBody::Create(CreateRequest {
            instance: instance.clone(),
            type_name: TYPE.to_owned(),
            system: None,
            recreate_hash: String::new(),
            restarts: 0,
            sets: Default::default(),
            active: None,
            execution_kind: String::new(),
            rate: Some(10.0),
            log_path: folder.join("log").display().to_string(),
            on_disconnect: None,
            stand_in: None,
            realtime: None,
            execution_context: None,
        }),
        RequestBody::Activate { instance },
    ];
    for request in requests {
        manager.call(request, PATIENCE)?;
    }
    match manager.call(RequestBody::Inventory, PATIENCE)? {
        ResponseBody::Inventory(held) if held.components.iter().all(|c| c.state == "Active") => {
            Ok(manager)
        }
        other => bail!("the component is not Active: {other:?}"),
    }
}

fn connect(socket: &Path) -> Result<Client> {
    let end = Instant::now() + PATIENCE;
    loop {
        match Client::connect(socket, PATIENCE) {
            Ok(client) => return Ok(client),
            Err(e) => ensure!(
                Instant::now() < end,
                "{} does not answer: {e}",
                socket.display()
            ),
        }
        std::thread::sleep(LOOK);
    }
}

/// Ends a manager, and waits until it has gone.
fn end(mut manager: Client) -> Result<()> {
    manager.call(RequestBody::Shutdown, PATIENCE)?;
    let end = Instant::now() + PATIENCE;
    // Its end closes the connection.
    while manager.call(RequestBody::Inventory, PATIENCE).is_ok() {
        ensure!(Instant::now() < end, "a manager does not end");
    }
    Ok(())
}
