//! Both ends in one process.

use tokio::io::{AsyncReadExt, AsyncWriteExt, duplex, split};

use super::*;
use crate::pulse::End;

async fn pair(resident: bool) -> (Near, Link) {
    let (a, b) = duplex(64 * 1024);
    let ((near_from, near_to), (far_from, far_to)) = (split(a), split(b));
    let far = async {
        let far = far(far_from, far_to, "0.1.0").await?;
        far.serves(resident).await
    };
    let (near, far) = tokio::join!(near(near_from, near_to, "0.1.0"), far);
    (near.unwrap(), far.unwrap())
}

#[tokio::test]
async fn streams_of_both_sides_carry_much_at_once() {
    let (mut near, mut far) = pair(true).await;
    assert!(near.resident);
    let mut pulse = far.incoming.next().await.unwrap();
    assert_eq!(Kind::read(&mut pulse).await, Some(Kind::Pulse));
    let much = vec![7_u8; 3_000_000];
    let mut up = near.link.opener.open(Kind::Agent).await.unwrap();
    let mut down = far.opener.open(Kind::Module).await.unwrap();
    let send_up = async {
        up.write_all(&much).await.unwrap();
        up.shutdown().await.unwrap();
        // The other direction stays open.
        let mut answer = String::new();
        up.read_to_string(&mut answer).await.unwrap();
        answer
    };
    let take_up = async {
        let mut stream = far.incoming.next().await.unwrap();
        assert_eq!(Kind::read(&mut stream).await, Some(Kind::Agent));
        let mut all = Vec::new();
        stream.read_to_end(&mut all).await.unwrap();
        stream.write_all(b"thanks").await.unwrap();
        stream.shutdown().await.unwrap();
        all.len()
    };
    let send_down = async {
        down.write_all(&much).await.unwrap();
        down.shutdown().await.unwrap();
    };
    let take_down = async {
        let mut stream = near.link.incoming.next().await.unwrap();
        assert_eq!(Kind::read(&mut stream).await, Some(Kind::Module));
        let mut all = Vec::new();
        stream.read_to_end(&mut all).await.unwrap();
        all.len()
    };
    let (answer, up, (), down) = tokio::join!(send_up, take_up, send_down, take_down);
    assert_eq!(
        (answer.as_str(), up, down),
        ("thanks", 3_000_000, 3_000_000)
    );
}

#[tokio::test]
async fn an_agent_that_does_not_serve_says_why() {
    let (a, b) = duplex(1024);
    let ((near_from, near_to), (far_from, far_to)) = (split(a), split(b));
    let far = async {
        let far = far(far_from, far_to, "0.1.0").await.unwrap();
        far.fails("no space left on device".to_owned()).await
    };
    let (near, far) = tokio::join!(near(near_from, near_to, "0.1.0"), far);
    far.unwrap();
    let error = near.unwrap_err().to_string();
    assert_eq!(
        error,
        "the agent there does not serve: no space left on device"
    );
}

#[tokio::test]
async fn another_version_names_what_to_do() {
    let (a, b) = duplex(1024);
    let (near_from, near_to) = split(a);
    let (_from, mut to) = split(b);
    to.write_all(b"rts-agent-stdio {\"version\":9,\"program\":\"7\"}\n")
        .await
        .unwrap();
    let error = near(near_from, near_to, "0.1.0").await.unwrap_err();
    assert!(error.to_string().contains("version 9"), "{error}");
}

#[tokio::test]
async fn whoever_is_dropped_is_missed_by_the_other() {
    let (near, mut far) = pair(false).await;
    assert!(far.incoming.next().await.is_some(), "the pulse");
    let Near { link, pulse, .. } = near;
    drop((link, pulse));
    far.ended().await;
    assert!(far.opener.open(Kind::Controller).await.is_err());
    assert!(far.incoming.next().await.is_none());
}

#[tokio::test(start_paused = true)]
async fn a_far_side_that_says_nothing_more_is_lost_and_one_that_was_told_says_so() {
    let (near, mut far) = pair(false).await;
    let mut pulse = far.incoming.next().await.unwrap();
    Kind::read(&mut pulse).await.unwrap();
    // It lives, and answers nothing.
    assert_eq!(near.pulse.keep().await, End::Lost);

    let (near, mut far) = pair(false).await;
    let mut pulse = far.incoming.next().await.unwrap();
    Kind::read(&mut pulse).await.unwrap();
    let told = tokio::time::sleep(Duration::from_secs(20));
    let ends = tokio::join!(near.pulse.keep(), pulse::far(pulse, told));
    assert_eq!(ends, (End::Told, End::Told));
}

#[tokio::test]
async fn bytes_that_mean_nothing_end_the_connection() {
    let (a, b) = duplex(64 * 1024);
    let ((near_from, near_to), (mut from, mut to)) = (split(a), split(b));
    let far = async {
        hello::write(
            &mut to,
            MARK,
            &FarHello {
                version: VERSION,
                program: String::new(),
            },
        )
        .await
        .unwrap();
        hello::write(&mut to, "", &Outcome::Serves { resident: false })
            .await
            .unwrap();
        to.write_all(&[0xff; 4096]).await.unwrap();
        let mut rest = Vec::new();
        let _ = from.read_to_end(&mut rest).await;
    };
    let near = async {
        if let Ok(mut near) = near(near_from, near_to, "0.1.0").await {
            near.link.ended().await;
        }
    };
    tokio::join!(near, far);
}
