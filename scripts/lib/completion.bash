# Completes scripts/ros2, and ros2 in a shell that sourced scripts/activate; sourced, not run.

_red_queen_ros2() {
    local word=${COMP_WORDS[COMP_CWORD]} command=${COMP_WORDS[1]} package=${COMP_WORDS[2]} words=
    case $COMP_CWORD:$command in
        1:*) words='run launch pkg node topic service param lifecycle bag --help --version' ;;
        2:run | 2:launch) words=$("${COMP_WORDS[0]}" pkg list 2>/dev/null) ;;
        2:pkg) words='executables list prefix' ;;
        2:node) words=list ;;
        2:topic) words='list echo hz' ;;
        2:service) words=call ;;
        2:param | 2:lifecycle) words='get set' ;;
        2:bag) words=info ;;
        3:run)
            words=$("${COMP_WORDS[0]}" pkg executables "$package" 2>/dev/null | cut -d ' ' -f 2)
            ;;
        3:launch)
            words=$("${COMP_WORDS[0]}" pkg prefix --share "$package" 2>/dev/null)
            words=$(cd "$words/launch" 2>/dev/null && ls)
            ;;
    esac
    COMPREPLY=($(compgen -W "$words" -- "$word"))
}

# Where it knows no words, file names.
complete -o default -F _red_queen_ros2 ros2
