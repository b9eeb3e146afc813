"""What `import` finds: stand-ins, generated messages, vendors' libraries."""
