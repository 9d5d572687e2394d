/* Defect: assembly whose frame is larger than the whole limit of the call chain; no compiler knows of it. */
    .text
    .global canary_assembly
    .type   canary_assembly, %function
canary_assembly:
    stp     x29, x30, [sp, #-16]!
    sub     sp, sp, #2, lsl #12
    str     x0, [sp]
    add     sp, sp, #2, lsl #12
    ldp     x29, x30, [sp], #16
    ret
    .size   canary_assembly, . - canary_assembly
