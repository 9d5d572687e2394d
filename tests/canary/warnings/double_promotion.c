/* Defect: a float that silently becomes a double. */
double canary_promotion(float value);

double canary_promotion(float value)
{
    return value * 0.5;
}
