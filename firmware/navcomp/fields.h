/* fields.h - the tables of fields of all that a navigation computer is configured with, for those who go through them:
 * scenario files, the commissioning record, the fingerprint of a run, the standard configuration.
 */
#ifndef TUMBLE_NAVCOMP_FIELDS_H
#define TUMBLE_NAVCOMP_FIELDS_H

#include "procedure/config_fields.h" /* averaging, procedure; and what the columns are */
#include "stand/drive402/profile_fields.h"

#endif
