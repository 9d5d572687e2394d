#include "tumble/status.h"

const char *tumble_status_name(tumble_status_t status)
{
    static const char *const names[] = {
#define TUMBLE_STATUS_NAME(name, sentence) #name,
        TUMBLE_STATUS_LIST(TUMBLE_STATUS_NAME)
#undef TUMBLE_STATUS_NAME
    };
    const unsigned index = (unsigned)status;
    return (index < (unsigned)TUMBLE_STATUS_COUNT) ? names[index] : "TUMBLE_STATUS_UNKNOWN";
}
