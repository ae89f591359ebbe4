"""What mkdocs.yml needs beside its themes: pages and pictures made from the package itself."""
