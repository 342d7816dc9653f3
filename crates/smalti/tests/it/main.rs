//! Laws, references and properties: one program, so that it is linked once.

mod common;
mod sensor_kit;

mod architecture;
mod camera_compare;
mod camera_training;
mod cfa;
mod cfa_catalog;
mod cfa_filters;
mod design_filters;
mod design_learned;
mod design_mosaics;
mod design_statistics;
mod design_targets;
mod design_toml;
mod isp;
mod l3_fallback;
mod l3_training;
mod metrics_aliasing;
mod metrics_esfr;
mod metrics_photon_transfer;
mod optics;
mod oracle_camera;
mod oracle_cfa;
mod oracle_color;
mod oracle_isp;
mod oracle_metrics;
mod oracle_optics;
mod oracle_scene;
mod oracle_sensor;
mod photon_transfer;
mod references;
mod scene;
mod scene_catalog;
mod sensor;
mod sensor_noise;
