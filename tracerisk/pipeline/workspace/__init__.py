"""The controller and its workspace as files: packages, own modules, libraries."""
