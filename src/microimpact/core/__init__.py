"""What every room uses: checked arrays, units, materials, compiled code, files and tables."""
