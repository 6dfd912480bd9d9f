// Generated from IDL by rtsctl: change the IDL file, not this one.

/// `module RTC`.
#[allow(dead_code, missing_docs, non_camel_case_types, non_snake_case, non_upper_case_globals, clippy::all)]
pub mod RTC {
    /// `RTC::TimedState`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedState {
        pub tm: ::rts_runtime::types::Time,
        pub data: i16,
    }

    impl ::rts_runtime::types::DataType for TimedState {
        const TYPE_ID: &'static str = "IDL:RTC/TimedState:1.0";
    }

    /// `RTC::TimedUShort`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedUShort {
        pub tm: ::rts_runtime::types::Time,
        pub data: u16,
    }

    impl ::rts_runtime::types::DataType for TimedUShort {
        const TYPE_ID: &'static str = "IDL:RTC/TimedUShort:1.0";
    }

    /// `RTC::TimedULong`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedULong {
        pub tm: ::rts_runtime::types::Time,
        pub data: u32,
    }

    impl ::rts_runtime::types::DataType for TimedULong {
        const TYPE_ID: &'static str = "IDL:RTC/TimedULong:1.0";
    }

    /// `RTC::TimedChar`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedChar {
        pub tm: ::rts_runtime::types::Time,
        pub data: u8,
    }

    impl ::rts_runtime::types::DataType for TimedChar {
        const TYPE_ID: &'static str = "IDL:RTC/TimedChar:1.0";
    }

    /// `RTC::TimedWChar`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedWChar {
        pub tm: ::rts_runtime::types::Time,
        pub data: ::rts_runtime::types::WChar,
    }

    impl ::rts_runtime::types::DataType for TimedWChar {
        const TYPE_ID: &'static str = "IDL:RTC/TimedWChar:1.0";
    }

    /// `RTC::TimedWString`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedWString {
        pub tm: ::rts_runtime::types::Time,
        pub data: ::rts_runtime::types::WString,
    }

    impl ::rts_runtime::types::DataType for TimedWString {
        const TYPE_ID: &'static str = "IDL:RTC/TimedWString:1.0";
    }

    /// `RTC::TimedUShortSeq`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedUShortSeq {
        pub tm: ::rts_runtime::types::Time,
        pub data: Vec<u16>,
    }

    impl ::rts_runtime::types::DataType for TimedUShortSeq {
        const TYPE_ID: &'static str = "IDL:RTC/TimedUShortSeq:1.0";
    }

    /// `RTC::TimedULongSeq`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedULongSeq {
        pub tm: ::rts_runtime::types::Time,
        pub data: Vec<u32>,
    }

    impl ::rts_runtime::types::DataType for TimedULongSeq {
        const TYPE_ID: &'static str = "IDL:RTC/TimedULongSeq:1.0";
    }

    /// `RTC::TimedCharSeq`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedCharSeq {
        pub tm: ::rts_runtime::types::Time,
        #[serde(serialize_with = "::rts_runtime::types::octets")]
        pub data: Vec<u8>,
    }

    impl ::rts_runtime::types::DataType for TimedCharSeq {
        const TYPE_ID: &'static str = "IDL:RTC/TimedCharSeq:1.0";
    }

    /// `RTC::TimedWCharSeq`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedWCharSeq {
        pub tm: ::rts_runtime::types::Time,
        pub data: Vec<::rts_runtime::types::WChar>,
    }

    impl ::rts_runtime::types::DataType for TimedWCharSeq {
        const TYPE_ID: &'static str = "IDL:RTC/TimedWCharSeq:1.0";
    }

    /// `RTC::TimedBooleanSeq`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedBooleanSeq {
        pub tm: ::rts_runtime::types::Time,
        pub data: Vec<bool>,
    }

    impl ::rts_runtime::types::DataType for TimedBooleanSeq {
        const TYPE_ID: &'static str = "IDL:RTC/TimedBooleanSeq:1.0";
    }

    /// `RTC::TimedStringSeq`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedStringSeq {
        pub tm: ::rts_runtime::types::Time,
        pub data: Vec<String>,
    }

    impl ::rts_runtime::types::DataType for TimedStringSeq {
        const TYPE_ID: &'static str = "IDL:RTC/TimedStringSeq:1.0";
    }

    /// `RTC::TimedWStringSeq`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedWStringSeq {
        pub tm: ::rts_runtime::types::Time,
        pub data: Vec<::rts_runtime::types::WString>,
    }

    impl ::rts_runtime::types::DataType for TimedWStringSeq {
        const TYPE_ID: &'static str = "IDL:RTC/TimedWStringSeq:1.0";
    }

    /// `RTC::RGBColour`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct RGBColour {
        pub r: f64,
        pub g: f64,
        pub b: f64,
    }

    impl ::rts_runtime::types::DataType for RGBColour {
        const TYPE_ID: &'static str = "IDL:RTC/RGBColour:1.0";
    }

    /// `RTC::Point2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Point2D {
        pub x: f64,
        pub y: f64,
    }

    impl ::rts_runtime::types::DataType for Point2D {
        const TYPE_ID: &'static str = "IDL:RTC/Point2D:1.0";
    }

    /// `RTC::Vector2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Vector2D {
        pub x: f64,
        pub y: f64,
    }

    impl ::rts_runtime::types::DataType for Vector2D {
        const TYPE_ID: &'static str = "IDL:RTC/Vector2D:1.0";
    }

    /// `RTC::Pose2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Pose2D {
        pub position: Point2D,
        pub heading: f64,
    }

    impl ::rts_runtime::types::DataType for Pose2D {
        const TYPE_ID: &'static str = "IDL:RTC/Pose2D:1.0";
    }

    /// `RTC::Velocity2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Velocity2D {
        pub vx: f64,
        pub vy: f64,
        pub va: f64,
    }

    impl ::rts_runtime::types::DataType for Velocity2D {
        const TYPE_ID: &'static str = "IDL:RTC/Velocity2D:1.0";
    }

    /// `RTC::Acceleration2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Acceleration2D {
        pub ax: f64,
        pub ay: f64,
    }

    impl ::rts_runtime::types::DataType for Acceleration2D {
        const TYPE_ID: &'static str = "IDL:RTC/Acceleration2D:1.0";
    }

    /// `RTC::PoseVel2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct PoseVel2D {
        pub pose: Pose2D,
        pub velocities: Velocity2D,
    }

    impl ::rts_runtime::types::DataType for PoseVel2D {
        const TYPE_ID: &'static str = "IDL:RTC/PoseVel2D:1.0";
    }

    /// `RTC::Size2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Size2D {
        pub l: f64,
        pub w: f64,
    }

    impl ::rts_runtime::types::DataType for Size2D {
        const TYPE_ID: &'static str = "IDL:RTC/Size2D:1.0";
    }

    /// `RTC::Geometry2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Geometry2D {
        pub pose: Pose2D,
        pub size: Size2D,
    }

    impl ::rts_runtime::types::DataType for Geometry2D {
        const TYPE_ID: &'static str = "IDL:RTC/Geometry2D:1.0";
    }

    /// `RTC::Covariance2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Covariance2D {
        pub xx: f64,
        pub xy: f64,
        pub xt: f64,
        pub yy: f64,
        pub yt: f64,
        pub tt: f64,
    }

    impl ::rts_runtime::types::DataType for Covariance2D {
        const TYPE_ID: &'static str = "IDL:RTC/Covariance2D:1.0";
    }

    /// `RTC::PointCovariance2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct PointCovariance2D {
        pub xx: f64,
        pub xy: f64,
        pub yy: f64,
    }

    impl ::rts_runtime::types::DataType for PointCovariance2D {
        const TYPE_ID: &'static str = "IDL:RTC/PointCovariance2D:1.0";
    }

    /// `RTC::Carlike`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Carlike {
        pub speed: f64,
        pub steeringAngle: f64,
    }

    impl ::rts_runtime::types::DataType for Carlike {
        const TYPE_ID: &'static str = "IDL:RTC/Carlike:1.0";
    }

    /// `RTC::SpeedHeading2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct SpeedHeading2D {
        pub speed: f64,
        pub heading: f64,
    }

    impl ::rts_runtime::types::DataType for SpeedHeading2D {
        const TYPE_ID: &'static str = "IDL:RTC/SpeedHeading2D:1.0";
    }

    /// `RTC::Point3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Point3D {
        pub x: f64,
        pub y: f64,
        pub z: f64,
    }

    impl ::rts_runtime::types::DataType for Point3D {
        const TYPE_ID: &'static str = "IDL:RTC/Point3D:1.0";
    }

    /// `RTC::Vector3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Vector3D {
        pub x: f64,
        pub y: f64,
        pub z: f64,
    }

    impl ::rts_runtime::types::DataType for Vector3D {
        const TYPE_ID: &'static str = "IDL:RTC/Vector3D:1.0";
    }

    /// `RTC::Orientation3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Orientation3D {
        pub r: f64,
        pub p: f64,
        pub y: f64,
    }

    impl ::rts_runtime::types::DataType for Orientation3D {
        const TYPE_ID: &'static str = "IDL:RTC/Orientation3D:1.0";
    }

    /// `RTC::Pose3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Pose3D {
        pub position: Point3D,
        pub orientation: Orientation3D,
    }

    impl ::rts_runtime::types::DataType for Pose3D {
        const TYPE_ID: &'static str = "IDL:RTC/Pose3D:1.0";
    }

    /// `RTC::Velocity3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Velocity3D {
        pub vx: f64,
        pub vy: f64,
        pub vz: f64,
        pub vr: f64,
        pub vp: f64,
        pub va: f64,
    }

    impl ::rts_runtime::types::DataType for Velocity3D {
        const TYPE_ID: &'static str = "IDL:RTC/Velocity3D:1.0";
    }

    /// `RTC::AngularVelocity3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct AngularVelocity3D {
        pub avx: f64,
        pub avy: f64,
        pub avz: f64,
    }

    impl ::rts_runtime::types::DataType for AngularVelocity3D {
        const TYPE_ID: &'static str = "IDL:RTC/AngularVelocity3D:1.0";
    }

    /// `RTC::Acceleration3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Acceleration3D {
        pub ax: f64,
        pub ay: f64,
        pub az: f64,
    }

    impl ::rts_runtime::types::DataType for Acceleration3D {
        const TYPE_ID: &'static str = "IDL:RTC/Acceleration3D:1.0";
    }

    /// `RTC::AngularAcceleration3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct AngularAcceleration3D {
        pub aax: f64,
        pub aay: f64,
        pub aaz: f64,
    }

    impl ::rts_runtime::types::DataType for AngularAcceleration3D {
        const TYPE_ID: &'static str = "IDL:RTC/AngularAcceleration3D:1.0";
    }

    /// `RTC::PoseVel3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct PoseVel3D {
        pub pose: Pose3D,
        pub velocities: Velocity3D,
    }

    impl ::rts_runtime::types::DataType for PoseVel3D {
        const TYPE_ID: &'static str = "IDL:RTC/PoseVel3D:1.0";
    }

    /// `RTC::Size3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Size3D {
        pub l: f64,
        pub w: f64,
        pub h: f64,
    }

    impl ::rts_runtime::types::DataType for Size3D {
        const TYPE_ID: &'static str = "IDL:RTC/Size3D:1.0";
    }

    /// `RTC::Geometry3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Geometry3D {
        pub pose: Pose3D,
        pub size: Size3D,
    }

    impl ::rts_runtime::types::DataType for Geometry3D {
        const TYPE_ID: &'static str = "IDL:RTC/Geometry3D:1.0";
    }

    /// `RTC::Covariance3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Covariance3D {
        pub xx: f64,
        pub xy: f64,
        pub xz: f64,
        pub xr: f64,
        pub xp: f64,
        pub xa: f64,
        pub yy: f64,
        pub yz: f64,
        pub yr: f64,
        pub yp: f64,
        pub ya: f64,
        pub zz: f64,
        pub zr: f64,
        pub zp: f64,
        pub za: f64,
        pub rr: f64,
        pub rp: f64,
        pub ra: f64,
        pub pp: f64,
        pub pa: f64,
        pub aa: f64,
    }

    impl ::rts_runtime::types::DataType for Covariance3D {
        const TYPE_ID: &'static str = "IDL:RTC/Covariance3D:1.0";
    }

    /// `RTC::SpeedHeading3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct SpeedHeading3D {
        pub speed: f64,
        pub direction: Orientation3D,
    }

    impl ::rts_runtime::types::DataType for SpeedHeading3D {
        const TYPE_ID: &'static str = "IDL:RTC/SpeedHeading3D:1.0";
    }

    /// `RTC::OAP`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct OAP {
        pub orientation: Vector3D,
        pub approach: Vector3D,
        pub position: Vector3D,
    }

    impl ::rts_runtime::types::DataType for OAP {
        const TYPE_ID: &'static str = "IDL:RTC/OAP:1.0";
    }

    /// `RTC::TimedRGBColour`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedRGBColour {
        pub tm: ::rts_runtime::types::Time,
        pub data: RGBColour,
    }

    impl ::rts_runtime::types::DataType for TimedRGBColour {
        const TYPE_ID: &'static str = "IDL:RTC/TimedRGBColour:1.0";
    }

    /// `RTC::TimedPoint2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedPoint2D {
        pub tm: ::rts_runtime::types::Time,
        pub data: Point2D,
    }

    impl ::rts_runtime::types::DataType for TimedPoint2D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedPoint2D:1.0";
    }

    /// `RTC::TimedVector2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedVector2D {
        pub tm: ::rts_runtime::types::Time,
        pub data: Vector2D,
    }

    impl ::rts_runtime::types::DataType for TimedVector2D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedVector2D:1.0";
    }

    /// `RTC::TimedPose2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedPose2D {
        pub tm: ::rts_runtime::types::Time,
        pub data: Pose2D,
    }

    impl ::rts_runtime::types::DataType for TimedPose2D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedPose2D:1.0";
    }

    /// `RTC::TimedVelocity2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedVelocity2D {
        pub tm: ::rts_runtime::types::Time,
        pub data: Velocity2D,
    }

    impl ::rts_runtime::types::DataType for TimedVelocity2D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedVelocity2D:1.0";
    }

    /// `RTC::TimedAcceleration2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedAcceleration2D {
        pub tm: ::rts_runtime::types::Time,
        pub data: Acceleration2D,
    }

    impl ::rts_runtime::types::DataType for TimedAcceleration2D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedAcceleration2D:1.0";
    }

    /// `RTC::TimedPoseVel2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedPoseVel2D {
        pub tm: ::rts_runtime::types::Time,
        pub data: PoseVel2D,
    }

    impl ::rts_runtime::types::DataType for TimedPoseVel2D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedPoseVel2D:1.0";
    }

    /// `RTC::TimedSize2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedSize2D {
        pub tm: ::rts_runtime::types::Time,
        pub data: Size2D,
    }

    impl ::rts_runtime::types::DataType for TimedSize2D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedSize2D:1.0";
    }

    /// `RTC::TimedGeometry2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedGeometry2D {
        pub tm: ::rts_runtime::types::Time,
        pub data: Geometry2D,
    }

    impl ::rts_runtime::types::DataType for TimedGeometry2D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedGeometry2D:1.0";
    }

    /// `RTC::TimedCovariance2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedCovariance2D {
        pub tm: ::rts_runtime::types::Time,
        pub data: Covariance2D,
    }

    impl ::rts_runtime::types::DataType for TimedCovariance2D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedCovariance2D:1.0";
    }

    /// `RTC::TimedPointCovariance2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedPointCovariance2D {
        pub tm: ::rts_runtime::types::Time,
        pub data: PointCovariance2D,
    }

    impl ::rts_runtime::types::DataType for TimedPointCovariance2D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedPointCovariance2D:1.0";
    }

    /// `RTC::TimedCarlike`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedCarlike {
        pub tm: ::rts_runtime::types::Time,
        pub data: Carlike,
    }

    impl ::rts_runtime::types::DataType for TimedCarlike {
        const TYPE_ID: &'static str = "IDL:RTC/TimedCarlike:1.0";
    }

    /// `RTC::TimedSpeedHeading2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedSpeedHeading2D {
        pub tm: ::rts_runtime::types::Time,
        pub data: SpeedHeading2D,
    }

    impl ::rts_runtime::types::DataType for TimedSpeedHeading2D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedSpeedHeading2D:1.0";
    }

    /// `RTC::TimedPoint3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedPoint3D {
        pub tm: ::rts_runtime::types::Time,
        pub data: Point3D,
    }

    impl ::rts_runtime::types::DataType for TimedPoint3D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedPoint3D:1.0";
    }

    /// `RTC::TimedVector3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedVector3D {
        pub tm: ::rts_runtime::types::Time,
        pub data: Vector3D,
    }

    impl ::rts_runtime::types::DataType for TimedVector3D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedVector3D:1.0";
    }

    /// `RTC::TimedOrientation3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedOrientation3D {
        pub tm: ::rts_runtime::types::Time,
        pub data: Orientation3D,
    }

    impl ::rts_runtime::types::DataType for TimedOrientation3D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedOrientation3D:1.0";
    }

    /// `RTC::TimedPose3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedPose3D {
        pub tm: ::rts_runtime::types::Time,
        pub data: Pose3D,
    }

    impl ::rts_runtime::types::DataType for TimedPose3D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedPose3D:1.0";
    }

    /// `RTC::TimedVelocity3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedVelocity3D {
        pub tm: ::rts_runtime::types::Time,
        pub data: Velocity3D,
    }

    impl ::rts_runtime::types::DataType for TimedVelocity3D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedVelocity3D:1.0";
    }

    /// `RTC::TimedAngularVelocity3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedAngularVelocity3D {
        pub tm: ::rts_runtime::types::Time,
        pub data: AngularVelocity3D,
    }

    impl ::rts_runtime::types::DataType for TimedAngularVelocity3D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedAngularVelocity3D:1.0";
    }

    /// `RTC::TimedAcceleration3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedAcceleration3D {
        pub tm: ::rts_runtime::types::Time,
        pub data: Acceleration3D,
    }

    impl ::rts_runtime::types::DataType for TimedAcceleration3D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedAcceleration3D:1.0";
    }

    /// `RTC::TimedAngularAcceleration3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedAngularAcceleration3D {
        pub tm: ::rts_runtime::types::Time,
        pub data: AngularAcceleration3D,
    }

    impl ::rts_runtime::types::DataType for TimedAngularAcceleration3D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedAngularAcceleration3D:1.0";
    }

    /// `RTC::TimedPoseVel3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedPoseVel3D {
        pub tm: ::rts_runtime::types::Time,
        pub data: PoseVel3D,
    }

    impl ::rts_runtime::types::DataType for TimedPoseVel3D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedPoseVel3D:1.0";
    }

    /// `RTC::TimedSize3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedSize3D {
        pub tm: ::rts_runtime::types::Time,
        pub data: Size3D,
    }

    impl ::rts_runtime::types::DataType for TimedSize3D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedSize3D:1.0";
    }

    /// `RTC::TimedGeometry3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedGeometry3D {
        pub tm: ::rts_runtime::types::Time,
        pub data: Geometry3D,
    }

    impl ::rts_runtime::types::DataType for TimedGeometry3D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedGeometry3D:1.0";
    }

    /// `RTC::TimedCovariance3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedCovariance3D {
        pub tm: ::rts_runtime::types::Time,
        pub data: Covariance3D,
    }

    impl ::rts_runtime::types::DataType for TimedCovariance3D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedCovariance3D:1.0";
    }

    /// `RTC::TimedSpeedHeading3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedSpeedHeading3D {
        pub tm: ::rts_runtime::types::Time,
        pub data: SpeedHeading3D,
    }

    impl ::rts_runtime::types::DataType for TimedSpeedHeading3D {
        const TYPE_ID: &'static str = "IDL:RTC/TimedSpeedHeading3D:1.0";
    }

    /// `RTC::TimedOAP`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedOAP {
        pub tm: ::rts_runtime::types::Time,
        pub data: OAP,
    }

    impl ::rts_runtime::types::DataType for TimedOAP {
        const TYPE_ID: &'static str = "IDL:RTC/TimedOAP:1.0";
    }

    /// `RTC::Quaternion`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Quaternion {
        pub x: f64,
        pub y: f64,
        pub z: f64,
        pub w: f64,
    }

    impl ::rts_runtime::types::DataType for Quaternion {
        const TYPE_ID: &'static str = "IDL:RTC/Quaternion:1.0";
    }

    /// `RTC::TimedQuaternion`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct TimedQuaternion {
        pub tm: ::rts_runtime::types::Time,
        pub data: Quaternion,
    }

    impl ::rts_runtime::types::DataType for TimedQuaternion {
        const TYPE_ID: &'static str = "IDL:RTC/TimedQuaternion:1.0";
    }

    /// `RTC::ActArrayActuatorPos`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct ActArrayActuatorPos {
        pub tm: ::rts_runtime::types::Time,
        pub index: u16,
        pub position: f64,
    }

    impl ::rts_runtime::types::DataType for ActArrayActuatorPos {
        const TYPE_ID: &'static str = "IDL:RTC/ActArrayActuatorPos:1.0";
    }

    /// `RTC::ActArrayActuatorSpeed`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct ActArrayActuatorSpeed {
        pub tm: ::rts_runtime::types::Time,
        pub index: u16,
        pub speed: f64,
    }

    impl ::rts_runtime::types::DataType for ActArrayActuatorSpeed {
        const TYPE_ID: &'static str = "IDL:RTC/ActArrayActuatorSpeed:1.0";
    }

    /// `RTC::ActArrayActuatorCurrent`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct ActArrayActuatorCurrent {
        pub tm: ::rts_runtime::types::Time,
        pub index: u16,
        pub current: f64,
    }

    impl ::rts_runtime::types::DataType for ActArrayActuatorCurrent {
        const TYPE_ID: &'static str = "IDL:RTC/ActArrayActuatorCurrent:1.0";
    }

    /// `RTC::ActArrayActuatorStatus`.
    #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub enum ActArrayActuatorStatus {
        #[default]
        /// 0.
        ACTUATOR_STATUS_IDLE,
        /// 1.
        ACTUATOR_STATUS_MOVING,
        /// 2.
        ACTUATOR_STATUS_BRAKED,
        /// 3.
        ACTUATOR_STATUS_STALLED,
    }

    /// `RTC::Actuator`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Actuator {
        pub position: f64,
        pub speed: f64,
        pub accel: f64,
        pub current: f64,
        pub status: ActArrayActuatorStatus,
    }

    impl ::rts_runtime::types::DataType for Actuator {
        const TYPE_ID: &'static str = "IDL:RTC/Actuator:1.0";
    }

    /// `RTC::ActuatorList`.
    pub type ActuatorList = Vec<Actuator>;

    /// `RTC::ActArrayState`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct ActArrayState {
        pub tm: ::rts_runtime::types::Time,
        pub actuators: ActuatorList,
    }

    impl ::rts_runtime::types::DataType for ActArrayState {
        const TYPE_ID: &'static str = "IDL:RTC/ActArrayState:1.0";
    }

    /// `RTC::ActArrayActuatorType`.
    #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub enum ActArrayActuatorType {
        #[default]
        /// 0.
        ACTARRAY_ACTUATORTYPE_LINEAR,
        /// 1.
        ACTARRAY_ACTUATORTYPE_ROTARY,
    }

    /// `RTC::ActArrayActuatorGeometry`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct ActArrayActuatorGeometry {
        pub r#type: ActArrayActuatorType,
        pub length: f64,
        pub orientation: Orientation3D,
        pub axis: Vector3D,
        pub minRange: f64,
        pub centre: f64,
        pub maxRange: f64,
        pub homePosition: f64,
        pub hasBrakes: bool,
    }

    impl ::rts_runtime::types::DataType for ActArrayActuatorGeometry {
        const TYPE_ID: &'static str = "IDL:RTC/ActArrayActuatorGeometry:1.0";
    }

    /// `RTC::ActArrayActuatorGeometryList`.
    pub type ActArrayActuatorGeometryList = Vec<ActArrayActuatorGeometry>;

    /// `RTC::ActArrayGeometry`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct ActArrayGeometry {
        pub arrayGeometry: Geometry3D,
        pub actuatorGeometry: ActArrayActuatorGeometryList,
    }

    impl ::rts_runtime::types::DataType for ActArrayGeometry {
        const TYPE_ID: &'static str = "IDL:RTC/ActArrayGeometry:1.0";
    }

    /// `RTC::BumperGeometry`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct BumperGeometry {
        pub pose: Pose3D,
        pub size: Size3D,
        pub roc: f64,
    }

    impl ::rts_runtime::types::DataType for BumperGeometry {
        const TYPE_ID: &'static str = "IDL:RTC/BumperGeometry:1.0";
    }

    /// `RTC::BumperGeometryList`.
    pub type BumperGeometryList = Vec<BumperGeometry>;

    /// `RTC::BumperArrayGeometry`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct BumperArrayGeometry {
        pub arrayGeometry: Geometry3D,
        pub bumperGeometry: BumperGeometryList,
    }

    impl ::rts_runtime::types::DataType for BumperArrayGeometry {
        const TYPE_ID: &'static str = "IDL:RTC/BumperArrayGeometry:1.0";
    }

    /// `RTC::CameraImage`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct CameraImage {
        pub tm: ::rts_runtime::types::Time,
        pub width: u16,
        pub height: u16,
        pub bpp: u16,
        pub format: String,
        pub fDiv: f64,
        #[serde(serialize_with = "::rts_runtime::types::octets")]
        pub pixels: Vec<u8>,
    }

    impl ::rts_runtime::types::DataType for CameraImage {
        const TYPE_ID: &'static str = "IDL:RTC/CameraImage:1.0";
    }

    /// `RTC::CameraInfo`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct CameraInfo {
        pub focalLength: Vector2D,
        pub principalPoint: Point2D,
        pub k1: f64,
        pub k2: f64,
        pub p1: f64,
        pub p2: f64,
    }

    impl ::rts_runtime::types::DataType for CameraInfo {
        const TYPE_ID: &'static str = "IDL:RTC/CameraInfo:1.0";
    }

    /// `RTC::FiducialInfo`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct FiducialInfo {
        pub id: u32,
        pub pose: Pose3D,
        pub poseUncertainty: Pose3D,
        pub size: Size3D,
        pub sizeUncertainty: Size3D,
    }

    impl ::rts_runtime::types::DataType for FiducialInfo {
        const TYPE_ID: &'static str = "IDL:RTC/FiducialInfo:1.0";
    }

    /// `RTC::FiducialInfoList`.
    pub type FiducialInfoList = Vec<FiducialInfo>;

    /// `RTC::Fiducials`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Fiducials {
        pub tm: ::rts_runtime::types::Time,
        pub fiducialsList: FiducialInfoList,
    }

    impl ::rts_runtime::types::DataType for Fiducials {
        const TYPE_ID: &'static str = "IDL:RTC/Fiducials:1.0";
    }

    /// `RTC::FiducialFOV`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct FiducialFOV {
        pub minRange: f64,
        pub maxRange: f64,
        pub viewAngle: f64,
    }

    impl ::rts_runtime::types::DataType for FiducialFOV {
        const TYPE_ID: &'static str = "IDL:RTC/FiducialFOV:1.0";
    }

    /// `RTC::GPSTime`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct GPSTime {
        pub sec: u32,
        pub msec: u32,
    }

    impl ::rts_runtime::types::DataType for GPSTime {
        const TYPE_ID: &'static str = "IDL:RTC/GPSTime:1.0";
    }

    /// `RTC::GPSFixType`.
    #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub enum GPSFixType {
        #[default]
        /// 0.
        GPS_FIX_NONE,
        /// 1.
        GPS_FIX_NORMAL,
        /// 2.
        GPS_FIX_DGPS,
    }

    /// `RTC::GPSData`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct GPSData {
        pub tm: ::rts_runtime::types::Time,
        pub timeFromGPS: GPSTime,
        pub latitude: f64,
        pub longitude: f64,
        pub altitude: f64,
        pub horizontalError: f64,
        pub verticalError: f64,
        pub heading: f64,
        pub horizontalSpeed: f64,
        pub verticalSpeed: f64,
        pub numSatellites: u16,
        pub fixType: GPSFixType,
    }

    impl ::rts_runtime::types::DataType for GPSData {
        const TYPE_ID: &'static str = "IDL:RTC/GPSData:1.0";
    }

    /// `RTC::GripperStatus`.
    #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub enum GripperStatus {
        #[default]
        /// 0.
        GRIPPER_STATE_OPEN,
        /// 1.
        GRIPPER_STATE_CLOSED,
        /// 2.
        GRIPPER_STATE_MOVING,
        /// 3.
        GRIPPER_STATE_UNKNOWN,
    }

    /// `RTC::GripperState`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct GripperState {
        pub tm: ::rts_runtime::types::Time,
        pub status: GripperStatus,
    }

    impl ::rts_runtime::types::DataType for GripperState {
        const TYPE_ID: &'static str = "IDL:RTC/GripperState:1.0";
    }

    /// `RTC::GripperGeometry`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct GripperGeometry {
        pub exterior: Geometry3D,
        pub interior: Geometry3D,
    }

    impl ::rts_runtime::types::DataType for GripperGeometry {
        const TYPE_ID: &'static str = "IDL:RTC/GripperGeometry:1.0";
    }

    /// `RTC::INSData`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct INSData {
        pub tm: ::rts_runtime::types::Time,
        pub latitude: f64,
        pub longitude: f64,
        pub altitude: f64,
        pub heightAMSL: f64,
        pub velocityENU: Velocity3D,
        pub orientation: Orientation3D,
    }

    impl ::rts_runtime::types::DataType for INSData {
        const TYPE_ID: &'static str = "IDL:RTC/INSData:1.0";
    }

    /// `RTC::LimbStatus`.
    #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub enum LimbStatus {
        #[default]
        /// 0.
        LIMB_STATUS_IDLE,
        /// 1.
        LIMB_STATUS_BRAKED,
        /// 2.
        LIMB_STATUS_MOVING,
        /// 3.
        LIMB_STATUS_OOR,
        /// 4.
        LIMB_STATUS_COLLISION,
    }

    /// `RTC::LimbState`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct LimbState {
        pub tm: ::rts_runtime::types::Time,
        pub oapMatrix: OAP,
        pub status: LimbStatus,
    }

    impl ::rts_runtime::types::DataType for LimbState {
        const TYPE_ID: &'static str = "IDL:RTC/LimbState:1.0";
    }

    /// `RTC::Hypothesis2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Hypothesis2D {
        pub mean: Pose2D,
        pub covariance: Covariance2D,
        pub weight: f64,
    }

    impl ::rts_runtime::types::DataType for Hypothesis2D {
        const TYPE_ID: &'static str = "IDL:RTC/Hypothesis2D:1.0";
    }

    /// `RTC::Hypothesis2DList`.
    pub type Hypothesis2DList = Vec<Hypothesis2D>;

    /// `RTC::Hypotheses2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Hypotheses2D {
        pub tm: ::rts_runtime::types::Time,
        pub hypotheses: Hypothesis2DList,
    }

    impl ::rts_runtime::types::DataType for Hypotheses2D {
        const TYPE_ID: &'static str = "IDL:RTC/Hypotheses2D:1.0";
    }

    /// `RTC::Hypothesis3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Hypothesis3D {
        pub mean: Pose3D,
        pub covariance: Covariance3D,
        pub weight: f64,
    }

    impl ::rts_runtime::types::DataType for Hypothesis3D {
        const TYPE_ID: &'static str = "IDL:RTC/Hypothesis3D:1.0";
    }

    /// `RTC::Hypothesis3DList`.
    pub type Hypothesis3DList = Vec<Hypothesis3D>;

    /// `RTC::Hypotheses3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Hypotheses3D {
        pub tm: ::rts_runtime::types::Time,
        pub hypotheses: Hypothesis3DList,
    }

    impl ::rts_runtime::types::DataType for Hypotheses3D {
        const TYPE_ID: &'static str = "IDL:RTC/Hypotheses3D:1.0";
    }

    /// `RTC::OGMapConfig`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct OGMapConfig {
        pub xScale: f64,
        pub yScale: f64,
        pub width: u32,
        pub height: u32,
        pub origin: Pose2D,
    }

    impl ::rts_runtime::types::DataType for OGMapConfig {
        const TYPE_ID: &'static str = "IDL:RTC/OGMapConfig:1.0";
    }

    /// `RTC::OGMapCells`.
    pub type OGMapCells = Vec<u8>;

    /// `RTC::OGMapTile`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct OGMapTile {
        pub column: u32,
        pub row: u32,
        pub width: u32,
        pub height: u32,
        #[serde(serialize_with = "::rts_runtime::types::octets")]
        pub cells: OGMapCells,
    }

    impl ::rts_runtime::types::DataType for OGMapTile {
        const TYPE_ID: &'static str = "IDL:RTC/OGMapTile:1.0";
    }

    /// `RTC::PointFeature`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct PointFeature {
        pub probability: f64,
        pub position: Point2D,
        pub covariance: PointCovariance2D,
    }

    impl ::rts_runtime::types::DataType for PointFeature {
        const TYPE_ID: &'static str = "IDL:RTC/PointFeature:1.0";
    }

    /// `RTC::PointFeatureList`.
    pub type PointFeatureList = Vec<PointFeature>;

    /// `RTC::PoseFeature`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct PoseFeature {
        pub probability: f64,
        pub position: Pose2D,
        pub covariance: Covariance2D,
    }

    impl ::rts_runtime::types::DataType for PoseFeature {
        const TYPE_ID: &'static str = "IDL:RTC/PoseFeature:1.0";
    }

    /// `RTC::PoseFeatureList`.
    pub type PoseFeatureList = Vec<PoseFeature>;

    /// `RTC::LineFeature`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct LineFeature {
        pub probability: f64,
        pub rho: f64,
        pub alpha: f64,
        pub covariance: PointCovariance2D,
        pub start: Point2D,
        pub end: Point2D,
        pub startSighted: bool,
        pub endSighted: bool,
    }

    impl ::rts_runtime::types::DataType for LineFeature {
        const TYPE_ID: &'static str = "IDL:RTC/LineFeature:1.0";
    }

    /// `RTC::LineFeatureList`.
    pub type LineFeatureList = Vec<LineFeature>;

    /// `RTC::Features`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Features {
        pub tm: ::rts_runtime::types::Time,
        pub pointFeatures: PointFeatureList,
        pub poseFeatures: PoseFeatureList,
        pub lineFeatures: LineFeatureList,
    }

    impl ::rts_runtime::types::DataType for Features {
        const TYPE_ID: &'static str = "IDL:RTC/Features:1.0";
    }

    /// `RTC::MulticameraImageList`.
    pub type MulticameraImageList = Vec<CameraImage>;

    /// `RTC::MultiCameraImages`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct MultiCameraImages {
        pub tm: ::rts_runtime::types::Time,
        pub images: MulticameraImageList,
    }

    impl ::rts_runtime::types::DataType for MultiCameraImages {
        const TYPE_ID: &'static str = "IDL:RTC/MultiCameraImages:1.0";
    }

    /// `RTC::MulticameraInfoList`.
    pub type MulticameraInfoList = Vec<CameraInfo>;

    /// `RTC::MulticameraGeometryList`.
    pub type MulticameraGeometryList = Vec<Geometry3D>;

    /// `RTC::MulticameraGeometry`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct MulticameraGeometry {
        pub geometry: Geometry3D,
        pub cameraGeometries: MulticameraGeometryList,
    }

    impl ::rts_runtime::types::DataType for MulticameraGeometry {
        const TYPE_ID: &'static str = "IDL:RTC/MulticameraGeometry:1.0";
    }

    /// `RTC::Waypoint2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Waypoint2D {
        pub target: Pose2D,
        pub distanceTolerance: f64,
        pub headingTolerance: f64,
        pub timeLimit: ::rts_runtime::types::Time,
        pub maxSpeed: Velocity2D,
    }

    impl ::rts_runtime::types::DataType for Waypoint2D {
        const TYPE_ID: &'static str = "IDL:RTC/Waypoint2D:1.0";
    }

    /// `RTC::Waypoint2DList`.
    pub type Waypoint2DList = Vec<Waypoint2D>;

    /// `RTC::Path2D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Path2D {
        pub tm: ::rts_runtime::types::Time,
        pub waypoints: Waypoint2DList,
    }

    impl ::rts_runtime::types::DataType for Path2D {
        const TYPE_ID: &'static str = "IDL:RTC/Path2D:1.0";
    }

    /// `RTC::Waypoint3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Waypoint3D {
        pub target: Pose3D,
        pub distanceTolerance: f64,
        pub headingTolerance: f64,
        pub timeLimit: ::rts_runtime::types::Time,
        pub maxSpeed: Velocity3D,
    }

    impl ::rts_runtime::types::DataType for Waypoint3D {
        const TYPE_ID: &'static str = "IDL:RTC/Waypoint3D:1.0";
    }

    /// `RTC::Waypoint3DList`.
    pub type Waypoint3DList = Vec<Waypoint3D>;

    /// `RTC::Path3D`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Path3D {
        pub tm: ::rts_runtime::types::Time,
        pub waypoints: Waypoint3DList,
    }

    impl ::rts_runtime::types::DataType for Path3D {
        const TYPE_ID: &'static str = "IDL:RTC/Path3D:1.0";
    }

    /// `RTC::PointCloudPoint`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct PointCloudPoint {
        pub point: Point3D,
        pub colour: RGBColour,
    }

    impl ::rts_runtime::types::DataType for PointCloudPoint {
        const TYPE_ID: &'static str = "IDL:RTC/PointCloudPoint:1.0";
    }

    /// `RTC::PointCloudPointList`.
    pub type PointCloudPointList = Vec<PointCloudPoint>;

    /// `RTC::PointCloud`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct PointCloud {
        pub tm: ::rts_runtime::types::Time,
        pub points: PointCloudPointList,
    }

    impl ::rts_runtime::types::DataType for PointCloud {
        const TYPE_ID: &'static str = "IDL:RTC/PointCloud:1.0";
    }

    /// `RTC::PanTiltAngles`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct PanTiltAngles {
        pub tm: ::rts_runtime::types::Time,
        pub pan: f64,
        pub tilt: f64,
    }

    impl ::rts_runtime::types::DataType for PanTiltAngles {
        const TYPE_ID: &'static str = "IDL:RTC/PanTiltAngles:1.0";
    }

    /// `RTC::PanTiltState`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct PanTiltState {
        pub tm: ::rts_runtime::types::Time,
        pub angles: PanTiltAngles,
        pub panSpeed: f64,
        pub tiltSpeed: f64,
    }

    impl ::rts_runtime::types::DataType for PanTiltState {
        const TYPE_ID: &'static str = "IDL:RTC/PanTiltState:1.0";
    }

    /// `RTC::ElementGeometryList`.
    pub type ElementGeometryList = Vec<Geometry3D>;

    /// `RTC::RangerGeometry`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct RangerGeometry {
        pub geometry: Geometry3D,
        pub elementGeometries: ElementGeometryList,
    }

    impl ::rts_runtime::types::DataType for RangerGeometry {
        const TYPE_ID: &'static str = "IDL:RTC/RangerGeometry:1.0";
    }

    /// `RTC::RangerConfig`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct RangerConfig {
        pub minAngle: f64,
        pub maxAngle: f64,
        pub angularRes: f64,
        pub minRange: f64,
        pub maxRange: f64,
        pub rangeRes: f64,
        pub frequency: f64,
    }

    impl ::rts_runtime::types::DataType for RangerConfig {
        const TYPE_ID: &'static str = "IDL:RTC/RangerConfig:1.0";
    }

    /// `RTC::RangeList`.
    pub type RangeList = Vec<f64>;

    /// `RTC::RangeData`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct RangeData {
        pub tm: ::rts_runtime::types::Time,
        pub ranges: RangeList,
        pub geometry: RangerGeometry,
        pub config: RangerConfig,
    }

    impl ::rts_runtime::types::DataType for RangeData {
        const TYPE_ID: &'static str = "IDL:RTC/RangeData:1.0";
    }

    /// `RTC::IntensityList`.
    pub type IntensityList = Vec<f64>;

    /// `RTC::IntensityData`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct IntensityData {
        pub tm: ::rts_runtime::types::Time,
        pub intensities: IntensityList,
        pub geometry: RangerGeometry,
        pub config: RangerConfig,
    }

    impl ::rts_runtime::types::DataType for IntensityData {
        const TYPE_ID: &'static str = "IDL:RTC/IntensityData:1.0";
    }

    /// `RTC::RFIDTagData`.
    pub type RFIDTagData = Vec<u8>;
}
