"""What a run recorded, and what it says: activity, contacts, exposure."""
