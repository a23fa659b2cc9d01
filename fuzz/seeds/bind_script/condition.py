if (fresh("<milk>") and full("<milk>")) or not expired("<milk>") and on_something("<milk>", "<table>"):
    pass
