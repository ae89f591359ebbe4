"""Pages and pictures for mkdocs.yml in addition to its themes, made from the package itself."""
