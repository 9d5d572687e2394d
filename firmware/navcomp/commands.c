#include "navcomp/commands.h"

const char *tumble_command_name(tumble_command_t command)
{
    static const char *const names[] = {
#define TUMBLE_COMMAND_NAME(name, sentence) #name,
        TUMBLE_COMMAND_LIST(TUMBLE_COMMAND_NAME)
#undef TUMBLE_COMMAND_NAME
    };
    const unsigned index = (unsigned)command;
    return (index < (unsigned)TUMBLE_COMMAND_COUNT) ? names[index] : "TUMBLE_COMMAND_UNKNOWN";
}
