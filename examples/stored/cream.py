take_cream()
check_best_by_date("cream")
if expired("cream"):
    drop_cream()
else:
    shelve_cream()
