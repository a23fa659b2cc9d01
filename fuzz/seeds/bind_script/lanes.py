with parallel():
    with lane("left"):
        move_hand("left", to="<drill>")
        grasp_object("left")
        sync("held")
    with lane("right"):
        sync("held")
        move_hand("right", to="<rag>")
