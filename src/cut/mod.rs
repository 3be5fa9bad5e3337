//! Cutting a lapped solid along a stroke or a plane into pieces that are whole lapped solids \[LST 5.1.1\].
