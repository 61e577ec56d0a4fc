"""`python -m firstcontact`: the command, where its script is not on the path."""

from firstcontact.cli import main

if __name__ == "__main__":
    main()
