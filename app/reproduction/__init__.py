"""The paper's tables, mapped and evaluated anew."""
