//! The keys that OpenRTM-aist knows.

use crate::suggest;

/// Keys by name.
const KNOWN: [&str; 64] = [
    "config.version",
    "openrtm.name",
    "openrtm.version",
    "manager.name",
    "manager.instance_name",
    "manager.naming_formats",
    "manager.is_master",
    "manager.corba_servant",
    "manager.shutdown_on_nortcs",
    "manager.shutdown_auto",
    "manager.auto_shutdown_duration",
    "manager.termination_waittime",
    "manager.cpu_affinity",
    "manager.supported_languages",
    "manager.update_master_manager.enable",
    "manager.update_master_manager.interval",
    "manager.modules.load_path",
    "manager.modules.preload",
    "manager.modules.abs_path_allowed",
    "manager.modules.config_ext",
    "manager.modules.config_path",
    "manager.modules.detect_loadable",
    "manager.modules.download_allowed",
    "manager.modules.download_cleanup",
    "manager.modules.download_dir",
    "manager.modules.init_func_prefix",
    "manager.modules.init_func_suffix",
    "manager.modules.search_auto",
    "manager.preload.modules",
    "manager.components.precreate",
    "manager.components.preconnect",
    "manager.components.preactivation",
    "manager.components.naming_policy",
    "manager.local_service.modules",
    "manager.local_service.enabled_services",
    "corba.args",
    "corba.id",
    "corba.endpoint",
    "corba.endpoints",
    "corba.endpoints_ipv4",
    "corba.endpoints_ipv6",
    "corba.endpoint_property",
    "corba.alternate_iiop_addresses",
    "corba.master_manager",
    "corba.nameservers",
    "corba.name_servers",
    "corba.nameservice.replace_endpoint",
    "corba.update_master_manager.enable",
    "corba.update_master_manager.interval",
    "naming.enable",
    "naming.type",
    "naming.formats",
    "naming.update.enable",
    "naming.update.interval",
    "naming.update.rebind",
    "logger.enable",
    "logger.log_level",
    "logger.file_name",
    "logger.date_format",
    "logger.clock_type",
    "logger.plugins",
    "logger.escape_sequence_enable",
    "timer.enable",
    "timer.tick",
];

/// Beginnings of keys that go on freely.
const FAMILIES: [&str; 12] = [
    "exec_cxt.",
    "ec.",
    "logger.logstream.",
    "logger.stream_lock",
    "manager.local_service.",
    "manager.modules.C++.",
    "manager.modules.Java.",
    "manager.modules.Python.",
    "manager.modules.Lua.",
    "corba.ssl.",
    "port.",
    "sdo.service.",
];

/// True for a key that OpenRTM-aist knows.
pub(super) fn is_known(key: &str) -> bool {
    KNOWN.contains(&key) || FAMILIES.iter().any(|family| key.starts_with(family))
}

/// The key that was probably meant.
pub(super) fn nearest(key: &str) -> Option<&'static str> {
    match key {
        "manager.components.preactivate" => Some("manager.components.preactivation"),
        // Two letters apart at most: a word apart is another key.
        key => {
            suggest::nearest(key, KNOWN).filter(|near| strsim::damerau_levenshtein(key, near) <= 2)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_keys_and_slips() {
        assert!(is_known("manager.components.precreate"));
        assert!(is_known("exec_cxt.periodic.rate") && is_known("logger.logstream.a.b"));
        assert!(
            !is_known("manager.component.precreate") && !is_known("Category.X0.conf.default.a")
        );
        let meant = nearest("manager.component.precreate");
        assert_eq!(meant, Some("manager.components.precreate"));
        assert_eq!(nearest("manager.modules.loadRTCs"), None);
        assert_eq!(nearest("Category.X0.conf.default.a"), None);
    }
}
